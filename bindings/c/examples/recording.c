/* A recorded loop: a tool pushes a block over a table. Arguments: the path of a world scene, and the path of the
   recording, which `palpate info`, `palpate convert` and `palpate replay` read. */
#include <palpate.h>
#include <stdio.h>

int main(int argc, char **argv) {
  palpate_world *world;
  palpate_recorder *recorder;
  palpate_recorder_params params = palpate_recorder_params_default();
  palpate_recorded recorded = palpate_recorded_empty();
  if (argc != 3) {
    fprintf(stderr, "usage: recording WORLD.toml OUT.mcap\n");
    return 1;
  }
  if (palpate_world_open(argv[1], NULL, &world) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  params.device = "a motion along x";
  if (palpate_recorder_of_world(world, argv[2], &params, &recorder) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    palpate_world_free(world);
    return 1;
  }
  for (int tick = 0; tick < 400; tick++) {
    palpate_pose pose = {{-0.0265 + 5e-5 * tick, 0.003, 0.01}, {1.0, 0.0, 0.0, 0.0}}; /* read your device here [m] */
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
    palpate_world_output output = palpate_world_output_empty();
    palpate_wrench wrench;
    palpate_world_step(world, &sample, &wrench, 1, &output); /* command wrench.force [N] */
    palpate_recorder_world_tick(recorder, world, &sample, &output, &wrench); /* never waits */
  }
  if (palpate_recorder_close(recorder, &recorded) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    palpate_world_free(world);
    return 1;
  }
  printf("%llu of %llu ticks are in %s\n", (unsigned long long)recorded.ticks, (unsigned long long)recorded.ticks_made,
         argv[2]);
  palpate_world_free(world);
  return 0;
}
