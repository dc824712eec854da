/* Prints the wrench bits of a world along a straight line: SCENE X Y Z VX VY VZ, in m and m/s. examples/world.rs prints
   the same from Rust. */
#include <palpate.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void bits(double number) {
  uint64_t raw;
  memcpy(&raw, &number, sizeof raw);
  printf("%016llx ", (unsigned long long)raw);
}

int main(int argc, char **argv) {
  palpate_world *world;
  palpate_world_params params = palpate_world_params_default();
  palpate_world_output output = palpate_world_output_empty();
  double line[6];
  if (argc != 8) return 2;
  for (int at = 0; at < 6; at++) line[at] = strtod(argv[2 + at], NULL);
  params.force_limit = 5.0;
  if (palpate_world_open(argv[1], &params, &world) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  for (int tick = 0; tick < 400; tick++) {
    double time = tick * palpate_world_period(world);
    palpate_pose pose = {{0.0}, {1.0, 0.0, 0.0, 0.0}};
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
    palpate_wrench wrench;
    for (int axis = 0; axis < 3; axis++) pose.position[axis] = line[axis] + line[3 + axis] * time;
    if (tick == 100) pose.position[1] = NAN;
    if (tick == 150) sample.elapsed = 0.0013, sample.has_elapsed = 1;
    palpate_world_step(world, &sample, &wrench, 1, &output);
    if (tick == 200) {
      wrench.force[0] *= 0.5;
      palpate_world_report_sent(world, 0, &wrench);
    }
    for (int axis = 0; axis < 3; axis++) bits(wrench.force[axis]);
    for (int axis = 0; axis < 3; axis++) bits(wrench.torque[axis]);
    printf("%u %u\n", (unsigned)output.fault, (unsigned)output.sub_steps);
  }
  palpate_world_free(world);
  return 0;
}
