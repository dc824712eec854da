/* A world in a loop: a tool pushes a block over a table. Argument: the path of experiments/worlds/pushed-block.toml. */
#include <palpate.h>
#include <stdio.h>

int main(int argc, char **argv) {
  palpate_world *world;
  palpate_body_state block = palpate_body_state_empty();
  if (palpate_world_open(argc > 1 ? argv[1] : "pushed-block.toml", NULL, &world) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  for (int tick = 0; tick < 400; tick++) {
    palpate_pose pose = {{-0.0265 + 5e-5 * tick, 0.003, 0.01}, {1.0, 0.0, 0.0, 0.0}}; /* read your device here [m] */
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
    palpate_wrench wrench;
    palpate_world_step(world, &sample, &wrench, 1, NULL); /* command wrench.force [N] */
    if (tick % 50 == 49) {
      palpate_world_body_state(world, 0, &block);
      printf("%.3f s: %8.4f N, the block at %8.5f m\n", palpate_world_period(world) * tick, wrench.force[0],
             block.pose.position[0]);
    }
  }
  palpate_world_free(world);
  return 0;
}
