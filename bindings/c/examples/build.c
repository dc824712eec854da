/* A world that is built by calls and changed while it runs: a finger above a table pushes a block that appears, becomes
   lighter, moves back, and is removed. */
#include <palpate.h>
#include <stdio.h>

static int refused(palpate_status status) {
  if (status != PALPATE_STATUS_OK) fprintf(stderr, "%s\n", palpate_last_error());
  return status != PALPATE_STATUS_OK;
}

int main(void) {
  palpate_scene_params loop = palpate_scene_params_default();
  palpate_device_params device = palpate_device_params_default();
  palpate_body_params table = palpate_body_params_default(), block = table;
  palpate_shape point = palpate_shape_default(), plane = point, box = point;
  palpate_contact_law law = palpate_contact_law_default();
  palpate_scene *scene = NULL;
  palpate_world *world = NULL;
  int failed = 0;

  loop.period = 0.001;                                             /* [s] */
  device.mass[0] = device.mass[1] = device.mass[2] = 0.15;         /* about its effective mass [kg] */
  point.radius = 0.005;                                            /* [m] */
  plane.kind = PALPATE_SHAPE_KIND_HALF_SPACE;                      /* z <= 0 */
  box.kind = PALPATE_SHAPE_KIND_BOX;
  box.half_extents[0] = box.half_extents[1] = 0.02, box.half_extents[2] = 0.01;
  block.mass = 0.05, block.force[2] = -0.4905, block.pose.position[2] = 0.01; /* [kg], its weight [N], [m] */
  law.stiffness = 4000.0, law.damping = 4.0, law.friction = 0.4;   /* [N/m], [N s/m] */

  failed |= refused(palpate_scene_new(&loop, &scene));
  failed |= refused(palpate_scene_add_device(scene, "finger", &device, &point));
  failed |= refused(palpate_scene_add_body(scene, "table", &table, &plane));
  failed |= refused(palpate_scene_set_law(scene, "*", "*", &law)); /* everything touches everything */
  failed |= refused(palpate_world_of_scene(scene, NULL, &world));

  for (int tick = 0; tick < 1600 && !failed; tick++) {
    int phase = tick % 400; /* the finger goes 24 mm to the right and back, at 0.12 m/s */
    palpate_pose pose = {{-0.03 + 1.2e-4 * (phase < 200 ? phase : 400 - phase), 0.003, 0.01}, {1, 0, 0, 0}};
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1); /* read your device here [m] */
    palpate_wrench wrench;
    if (tick == 400) { /* between two ticks: allocates, as creating a world does */
      failed |= refused(palpate_scene_add_body(scene, "block", &block, &box));
      failed |= refused(palpate_world_change(world, scene));
    }
    if (tick == 800) {
      palpate_body_state back = palpate_body_state_empty();
      block.mass = 0.02, block.force[2] = -0.1962;
      failed |= refused(palpate_scene_set_body(scene, "block", &block, NULL));
      failed |= refused(palpate_world_change(world, scene));
      back.pose.position[2] = 0.01;
      failed |= refused(palpate_world_place(world, 1, &back)); /* does not allocate */
    }
    if (tick == 1200) {
      failed |= refused(palpate_scene_remove_body(scene, "block"));
      failed |= refused(palpate_world_change(world, scene));
    }
    palpate_world_step(world, &sample, &wrench, 1, NULL); /* command wrench.force here [N] */
    if (tick % 100 == 99) {
      palpate_body_state state = palpate_body_state_empty();
      printf("%4d ms: force %7.3f N", tick + 1, wrench.force[0]);
      if (palpate_world_body_count(world) > 1 && palpate_world_body_state(world, 1, &state) == PALPATE_STATUS_OK)
        printf(", block at %6.2f mm", 1000.0 * state.pose.position[0]);
      printf("\n");
    }
  }
  palpate_world_free(world);
  palpate_scene_free(scene);
  return failed;
}
