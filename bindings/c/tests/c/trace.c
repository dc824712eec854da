/* Runs every method over the device positions of a table with all optional inputs of a contact, and prints the bits of
   the full output as double. examples/trace.rs prints the same from Rust. With -DTICKS_IN_FLOAT the ticks are in float.
   */
#include <inttypes.h>
#include <math.h>
#include <palpate.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef TICKS_IN_FLOAT
typedef float number;
#define NAME(what) palpate_##what##_f32
#define CALL(what) palpate_contact_f32_##what
#define SAMPLE_AT palpate_sample_f32_at
#define EMPTY(what) palpate_##what##_f32_empty()
#else
typedef double number;
#define NAME(what) palpate_##what
#define CALL(what) palpate_contact_##what
#define SAMPLE_AT palpate_sample_at
#define EMPTY(what) palpate_##what##_empty()
#endif

enum { LARGEST_TABLE = 1000 };

static void put(double value) {
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  printf(" %016" PRIx64, bits);
}

/* Reads the second column of a table with a header. */
static int read_positions(const char *path, double *positions) {
  FILE *file = fopen(path, "r");
  char line[512];
  int count = 0;
  if (file == NULL || fgets(line, sizeof line, file) == NULL) {
    perror(path);
    exit(1);
  }
  while (count < LARGEST_TABLE && fgets(line, sizeof line, file) != NULL) {
    positions[count++] = strtod(strchr(line, ',') + 1, NULL);
  }
  fclose(file);
  return count;
}

static void run(const char *method, double object_position, const double *positions, int count) {
  palpate_loop_params loop = palpate_loop_params_default();
  palpate_contact_params params = palpate_contact_params_default();
  NAME(contact) *contact;
  int tick;
  loop.period = 0.01;
  loop.delay = 0.005;
  loop.delay_deviation = 0.0005;
  loop.lag = 0.0003;
  loop.gain = 0.98;
  loop.device_mass = 0.1;
  params.method = method;
  params.stiffness = 100.0;
  params.object_mass = 0.1;
  params.object_position = object_position;
  if (CALL(new)(&params, &loop, &contact) != PALPATE_STATUS_OK) {
    printf("%s: %s\n", method, palpate_last_error());
    return;
  }
  for (tick = 0; tick < count; tick++) {
    NAME(sample) sample = SAMPLE_AT(tick == 50 ? NAN : (number)positions[tick]);
    NAME(output) output = EMPTY(output);
    NAME(ledger) ledger = EMPTY(ledger);
    number force;
    sample.virtual_force = (number)-0.981;
    if (tick == 30) {
      sample.elapsed = (number)0.013;
      sample.has_elapsed = 1;
    }
    if (tick == 15) {
      params.stiffness = 200.0;
      params.object_mass = 0.2;
      CALL(change)(contact, &params, &loop);
    }
    if (tick == 60) {
      CALL(teleport)(contact, (number)(object_position - 0.001), (number)-0.1);
    }
    if (tick == 70) {
      params.method = "basic";
      CALL(change)(contact, &params, &loop);
    }
    force = CALL(step)(contact, &sample, &output);
    if (tick % 7 == 3) {
      CALL(report_sent)(contact, (number)0.5 * force);
    }
    if (tick % 7 == 5) {
      CALL(report_held)(contact, (number)0.9 * force);
    }
    CALL(ledger)(contact, &ledger);
    printf("%s %d", method, tick);
    put(force);
    put(output.force_on_device);
    put(output.force_on_object);
    put(output.slope_on_device);
    put(output.object_position);
    put(output.object_velocity);
    put(output.penetration);
    put(output.transition_after);
    put(output.proxy_shift);
    put(ledger.stored);
    put(ledger.port_work);
    put(ledger.virtual_force_work);
    put(ledger.outside_work);
    put(ledger.held_leak);
    put(ledger.held_leak_last);
    put(ledger.held_leak_absolute);
    put(ledger.original_leak);
    put(ledger.original_leak_last);
    put(ledger.original_leak_absolute);
    printf(" %u %u %u\n", (unsigned)output.phase, (unsigned)output.fault, (unsigned)output.limited);
  }
  CALL(free)(contact);
}

int main(int argc, char **argv) {
  static double positions[LARGEST_TABLE];
  size_t method;
  int count;
  if (argc != 3) {
    fprintf(stderr, "usage: trace TABLE.csv OBJECT_POSITION\n");
    return 1;
  }
  count = read_positions(argv[1], positions);
  for (method = 0; method < palpate_method_count(); method++) {
    char name[64];
    palpate_method_text(method, PALPATE_ABOUT_METHOD_NAME, name, sizeof name);
    run(name, strtod(argv[2], NULL), positions, count);
  }
  return 0;
}
