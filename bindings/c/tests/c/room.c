/* A recorder that needs more memory than the system has: an error status, and no file. Argument: the path of a
   recording. The program limits its address space to 2 GiB. */
#define _POSIX_C_SOURCE 200809L
#include <palpate.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

static int failures = 0;
#define EXPECT(condition)                                                                                      \
  do {                                                                                                         \
    if (!(condition)) {                                                                                        \
      fprintf(stderr, "room.c:%d: not so: %s (last error: %s)\n", __LINE__, #condition, palpate_last_error()); \
      failures++;                                                                                              \
    }                                                                                                          \
  } while (0)

int main(int argc, char **argv) {
  const struct rlimit limit = {(rlim_t)1 << 31, (rlim_t)1 << 31};
  palpate_loop_params loop = palpate_loop_params_default();
  palpate_contact_params wall = palpate_contact_params_default();
  palpate_recorder_params params = palpate_recorder_params_default();
  palpate_recorder *recorder;
  palpate_contact *contact;
  char part[4096];
  FILE *file;
  if (argc != 2 || setrlimit(RLIMIT_AS, &limit)) return 2;
  loop.period = 0.001, wall.stiffness = 1000.0, wall.method = "basic";
  EXPECT(palpate_contact_new(&wall, &loop, &contact) == PALPATE_STATUS_OK);
  params.room = (size_t)1 << 24;
  EXPECT(palpate_recorder_of_contact(contact, argv[1], &params, &recorder) == PALPATE_STATUS_MEMORY);
  EXPECT(recorder == NULL && strstr(palpate_last_error(), "a buffer for 16777216 ticks needs ") != NULL);
  snprintf(part, sizeof part, "%s.part", argv[1]);
  EXPECT((file = fopen(argv[1], "r")) == NULL && (file = fopen(part, "r")) == NULL);
  /* The failed call left no file. */
  params.room = 1000;
  EXPECT(palpate_recorder_of_contact(contact, argv[1], &params, &recorder) == PALPATE_STATUS_OK);
  EXPECT(palpate_recorder_close(recorder, NULL) == PALPATE_STATUS_OK);
  palpate_contact_free(contact);
  return failures != 0;
}
