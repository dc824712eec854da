/* Ticks of a world and palpate_world_place neither allocate nor free memory, before and after changes. Argument: SCENE.
   The program counts malloc and free, on glibc only, without valgrind or a sanitizer, which replace them. */
#include <palpate.h>
#include <stdio.h>

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *memory, size_t size);
extern void __libc_free(void *memory);

static int is_counting = 0, calls = 0;
void *malloc(size_t size) { return calls += is_counting, __libc_malloc(size); }
void *calloc(size_t count, size_t size) { return calls += is_counting, __libc_calloc(count, size); }
void *realloc(void *memory, size_t size) { return calls += is_counting, __libc_realloc(memory, size); }
void free(void *memory) { calls += is_counting, __libc_free(memory); }

static int wrong(const char *what) { return fprintf(stderr, "no_alloc.c: %s: %s\n", what, palpate_last_error()), 1; }

int main(int argc, char **argv) {
  palpate_scene *scene;
  palpate_world *world;
  palpate_body_params ball = palpate_body_params_default();
  palpate_body_state state = palpate_body_state_empty();
  palpate_shape sphere = palpate_shape_default();
  int ticks = 0;
  if (argc < 2 || palpate_scene_open(argv[1], &scene) != PALPATE_STATUS_OK) return wrong("open");
  if (palpate_world_of_scene(scene, NULL, &world) != PALPATE_STATUS_OK) return wrong("world");
  ball.mass = 0.01, ball.pose.position[2] = 0.5, sphere.radius = 0.01;
  for (int tick = 0; tick < 600; tick++) {
    palpate_pose pose = {{-0.0265 + 5e-5 * (tick % 300), 0.003, 0.01}, {1.0, 0.0, 0.0, 0.0}};
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
    palpate_wrench wrench;
    if (tick == 100 && palpate_scene_add_body(scene, "ball", &ball, &sphere) != PALPATE_STATUS_OK) return wrong("add");
    if (tick == 400 && palpate_scene_remove_body(scene, "ball") != PALPATE_STATUS_OK) return wrong("remove");
    /* Includes a second change before the first has settled. */
    if (tick == 100 || tick == 101 || tick == 400) {
      if (palpate_world_change(world, scene) != PALPATE_STATUS_OK) return wrong("change");
    }
    is_counting = 1;
    if (tick == 200 && palpate_world_body_state(world, 0, &state) != PALPATE_STATUS_OK) return wrong("state");
    if (tick == 200 && palpate_world_place(world, 0, &state) != PALPATE_STATUS_OK) return wrong("place");
    ticks += palpate_world_step(world, &sample, &wrench, 1, NULL) == PALPATE_FAULT_NONE;
    is_counting = 0;
  }
  if (ticks != 600) return wrong("ticks");
  if (calls != 0) return fprintf(stderr, "no_alloc.c: %d calls of malloc and free in ticks\n", calls), 1;
  is_counting = 1;
  palpate_world_free(world);
  palpate_scene_free(scene);
  is_counting = 0;
  if (calls == 0) return fprintf(stderr, "no_alloc.c: nothing is counted\n"), 1;
  return 0;
}
