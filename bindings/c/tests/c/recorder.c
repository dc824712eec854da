/* Caller errors of a recorder, a ring buffer overflow, and two devices of a world. Arguments: the path of a world
   scene; a folder for recordings, whose disk.mcap, short.mcap, left.mcap and right.mcap the check reads; the path of a
   scene of two devices, left and right. */
#include <math.h>
#include <palpate.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

static void expect(int line, int holds, const char *what) {
  if (!holds) {
    fprintf(stderr, "recorder.c:%d: not so: %s; last error: %s\n", line, what, palpate_last_error());
    failures++;
  }
}
#define EXPECT(condition) expect(__LINE__, (condition), #condition)
#define REFUSED(status, stated, words) \
  EXPECT((status) == (stated) && strstr(palpate_last_error(), (words)) != NULL)

static const char *folder;

static const char *in_folder(const char *name) {
  static char path[4096];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return path;
}

static palpate_contact *a_wall(void) {
  palpate_loop_params loop = palpate_loop_params_default();
  palpate_contact_params params = palpate_contact_params_default();
  palpate_contact *contact;
  loop.period = 0.001;
  params.method = "basic";
  params.stiffness = 1000.0;
  EXPECT(palpate_contact_new(&params, &loop, &contact) == PALPATE_STATUS_OK);
  return contact;
}

static palpate_status tick(palpate_recorder *recorder, palpate_contact *contact, double position) {
  palpate_sample sample = palpate_sample_at(position);
  palpate_output output = palpate_output_empty();
  double force = palpate_contact_step(contact, &sample, &output);
  return palpate_recorder_contact_tick(recorder, contact, &sample, &output, force, 0.0);
}

static void making(palpate_contact *contact) {
  palpate_recorder *recorder = (palpate_recorder *)1;
  palpate_recorder_params params = palpate_recorder_params_default();

  REFUSED(palpate_recorder_of_contact(contact, "there/is/none.mcap", NULL, &recorder), PALPATE_STATUS_RECORDING,
          "there/is/none.mcap");
  EXPECT(recorder == NULL);
  REFUSED(palpate_recorder_of_contact(NULL, in_folder("x.mcap"), NULL, &recorder), PALPATE_STATUS_NULL, "contact is NULL");
  REFUSED(palpate_recorder_of_world(NULL, in_folder("x.mcap"), NULL, &recorder), PALPATE_STATUS_NULL, "world is NULL");
  REFUSED(palpate_recorder_of_contact(contact, NULL, NULL, &recorder), PALPATE_STATUS_NULL, "path is NULL");
  EXPECT(palpate_recorder_of_contact(contact, in_folder("x.mcap"), NULL, NULL) == PALPATE_STATUS_NULL);
  params.device = "\xff";
  REFUSED(palpate_recorder_of_contact(contact, in_folder("x.mcap"), &params, &recorder), PALPATE_STATUS_SETTING,
          "device is not UTF-8");
  params = palpate_recorder_params_default();
  REFUSED(palpate_recorder_of_contact(contact, "", NULL, &recorder), PALPATE_STATUS_RECORDING, "the path names no file");
  params.room = (size_t)1 << 40;
  REFUSED(palpate_recorder_of_contact(contact, in_folder("x.mcap"), &params, &recorder), PALPATE_STATUS_PARAMETER,
          "room is 1099511627776 ticks, but must be at most 16777216");
  params.struct_size = 3;
  REFUSED(palpate_recorder_of_contact(contact, in_folder("x.mcap"), &params, &recorder), PALPATE_STATUS_STRUCT_SIZE,
          "palpate_recorder_params");
  EXPECT(palpate_recorder_close(NULL, NULL) == PALPATE_STATUS_OK && palpate_recorder_lost(NULL) == 0);
}

static void ticks(palpate_contact *contact, palpate_world *world) {
  palpate_recorder *recorder, *again;
  palpate_recorded recorded = palpate_recorded_empty();
  palpate_sample sample = palpate_sample_at(0.001);
  palpate_output output = palpate_output_empty();
  palpate_pose pose = {{0.0, 0.0, 0.1}, {1.0, 0.0, 0.0, 0.0}};
  palpate_world_sample of_world = palpate_world_sample_at(&pose, 1);
  palpate_world_output answer = palpate_world_output_empty();
  palpate_wrench wrench = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};

  EXPECT(palpate_recorder_of_contact(contact, in_folder("disk.mcap"), NULL, &recorder) == PALPATE_STATUS_OK);
  REFUSED(palpate_recorder_of_contact(contact, in_folder("disk.mcap"), NULL, &again), PALPATE_STATUS_RECORDING, "disk.mcap");
  EXPECT(again == NULL);
  EXPECT(tick(recorder, contact, 0.001) == PALPATE_STATUS_OK);
  REFUSED(palpate_recorder_world_tick(recorder, world, &of_world, &answer, &wrench), PALPATE_STATUS_RECORDING,
          "the recorder is for a contact, but this is a tick of a world");
  {
    palpate_contact *other = a_wall();
    REFUSED(palpate_recorder_contact_tick(recorder, other, &sample, &output, 0.0, 0.0), PALPATE_STATUS_RECORDING,
            "the recorder is for a contact, but this is a tick of another one");
    palpate_contact_free(other);
  }
  EXPECT(palpate_recorder_contact_tick(NULL, contact, &sample, &output, 0.0, 0.0) == PALPATE_STATUS_NULL);
  EXPECT(palpate_recorder_contact_tick(recorder, NULL, &sample, &output, 0.0, 0.0) == PALPATE_STATUS_NULL);
  EXPECT(palpate_recorder_contact_tick(recorder, contact, NULL, &output, 0.0, 0.0) == PALPATE_STATUS_NULL);
  EXPECT(palpate_recorder_contact_tick(recorder, contact, &sample, NULL, 0.0, 0.0) == PALPATE_STATUS_NULL);
  output.struct_size = 8;
  EXPECT(palpate_recorder_contact_tick(recorder, contact, &sample, &output, 0.0, 0.0) == PALPATE_STATUS_STRUCT_SIZE);
  /* A rejected sample is a tick of the recording, and so is an output that no tick has filled. */
  EXPECT(tick(recorder, contact, NAN) == PALPATE_STATUS_OK);
  memset(&output, 0xff, sizeof output);
  output.struct_size = sizeof output;
  EXPECT(palpate_recorder_contact_tick(recorder, contact, &sample, &output, 0.0, 0.0) == PALPATE_STATUS_OK);
  EXPECT(palpate_recorder_lost(recorder) == 0);
  EXPECT(palpate_recorder_close(recorder, &recorded) == PALPATE_STATUS_OK);
  EXPECT(recorded.ticks_made == 3 && recorded.ticks == 3 && recorded.lost == 0);

  EXPECT(palpate_recorder_of_world(world, in_folder("world.mcap"), NULL, &recorder) == PALPATE_STATUS_OK);
  REFUSED(palpate_recorder_contact_tick(recorder, contact, &sample, &output, 0.0, 0.0),
          PALPATE_STATUS_RECORDING, "the recorder is for a world, but this is a tick of a contact");
  of_world.pose_count = 2;
  REFUSED(palpate_recorder_world_tick(recorder, world, &of_world, &answer, &wrench), PALPATE_STATUS_COUNT, "pose_count is 2");
  of_world.pose_count = 1;
  of_world.poses = NULL;
  REFUSED(palpate_recorder_world_tick(recorder, world, &of_world, &answer, &wrench), PALPATE_STATUS_NULL, "poses is NULL");
  of_world.poses = &pose;
  EXPECT(palpate_recorder_world_tick(recorder, world, &of_world, &answer, NULL) == PALPATE_STATUS_NULL);
  EXPECT(palpate_recorder_world_tick(recorder, world, &of_world, &answer, &wrench) == PALPATE_STATUS_OK);
  recorded.struct_size = 8;
  /* The recorder is freed despite the error. */
  EXPECT(palpate_recorder_close(recorder, &recorded) == PALPATE_STATUS_STRUCT_SIZE);
}

static void overflow(palpate_contact *contact) {
  palpate_recorder *recorder;
  palpate_recorder_params params = palpate_recorder_params_default();
  palpate_recorded recorded = palpate_recorded_empty();
  uint64_t made = 0, lost;

  params.room = 1;
  EXPECT(palpate_recorder_of_contact(contact, in_folder("short.mcap"), &params, &recorder) == PALPATE_STATUS_OK);
  while (palpate_recorder_lost(recorder) == 0) {
    EXPECT(tick(recorder, contact, 0.001) == PALPATE_STATUS_OK);
    made++;
  }
  lost = palpate_recorder_lost(recorder);
  EXPECT(palpate_recorder_close(recorder, &recorded) == PALPATE_STATUS_OK);
  EXPECT(recorded.ticks_made == made && recorded.lost == lost && recorded.ticks == made - lost);
}

/* Two fingers that close on a cube, with one recording each. */
static void devices(const char *scene, palpate_world *of_one) {
  palpate_world *world, *again;
  palpate_recorder *left, *right, *none;
  palpate_recorded recorded = palpate_recorded_empty();

  EXPECT(palpate_world_open(scene, NULL, &world) == PALPATE_STATUS_OK);
  EXPECT(palpate_world_open(scene, NULL, &again) == PALPATE_STATUS_OK);
  REFUSED(palpate_recorder_of_world(world, in_folder("none.mcap"), NULL, &none), PALPATE_STATUS_COUNT,
          "the world has 2 devices");
  REFUSED(palpate_recorder_of_device(world, 2, in_folder("none.mcap"), NULL, &none), PALPATE_STATUS_COUNT,
          "device is 2, but must be less than 2");
  EXPECT(palpate_recorder_of_device(NULL, 0, in_folder("none.mcap"), NULL, &none) == PALPATE_STATUS_NULL);
  EXPECT(palpate_recorder_of_device(world, 0, in_folder("left.mcap"), NULL, &left) == PALPATE_STATUS_OK);
  EXPECT(palpate_recorder_of_device(world, 1, in_folder("right.mcap"), NULL, &right) == PALPATE_STATUS_OK);
  for (int tick = 0; tick < 200; tick++) {
    const double in = 2e-6 * tick; /* 0.2 mm into the cube in the end */
    palpate_pose poses[2] = {{{-0.0202 + in, 0.0005, 0.016}, {1.0, 0.0, 0.0, 0.0}},
                             {{0.0202 - in, -0.0003, 0.016}, {1.0, 0.0, 0.0, 0.0}}};
    palpate_world_sample sample = palpate_world_sample_at(poses, 2);
    palpate_world_output output = palpate_world_output_empty();
    palpate_wrench wrenches[2];
    EXPECT(palpate_world_step(world, &sample, wrenches, 2, &output) == PALPATE_FAULT_NONE);
    EXPECT(palpate_recorder_world_tick(left, world, &sample, &output, &wrenches[0]) == PALPATE_STATUS_OK);
    EXPECT(palpate_recorder_world_tick(right, world, &sample, &output, &wrenches[1]) == PALPATE_STATUS_OK);
    if (tick == 199) {
      EXPECT(wrenches[0].force[0] < -0.01 && wrenches[1].force[0] > 0.01);
      REFUSED(palpate_recorder_world_tick(right, of_one, &sample, &output, &wrenches[1]), PALPATE_STATUS_RECORDING,
              "the recorder is for a world, but this is a tick of another one");
      REFUSED(palpate_recorder_world_tick(right, again, &sample, &output, &wrenches[1]), PALPATE_STATUS_RECORDING,
              "a tick of another one");
      sample.pose_count = 1;
      EXPECT(palpate_recorder_world_tick(right, world, &sample, &output, &wrenches[1]) == PALPATE_STATUS_COUNT);
    }
  }
  EXPECT(palpate_recorder_close(left, &recorded) == PALPATE_STATUS_OK);
  EXPECT(recorded.ticks == 200 && recorded.lost == 0);
  EXPECT(palpate_recorder_close(right, &recorded) == PALPATE_STATUS_OK);
  EXPECT(recorded.ticks == 200 && recorded.lost == 0);
  palpate_world_free(world);
  palpate_world_free(again);
}

int main(int argc, char **argv) {
  palpate_contact *contact = a_wall();
  palpate_world *world;
  if (argc != 4) {
    fprintf(stderr, "usage: recorder WORLD.toml FOLDER WORLD_OF_TWO.toml\n");
    return 1;
  }
  folder = argv[2];
  EXPECT(palpate_world_open(argv[1], NULL, &world) == PALPATE_STATUS_OK);
  making(contact);
  ticks(contact, world);
  overflow(contact);
  devices(argv[3], world);
  palpate_contact_free(contact);
  palpate_world_free(world);
  return failures != 0;
}
