/* A 50 Hz simulator owns a ball on a floor; a 1 kHz loop renders both to a pressing hand. Here both run alternately in
   one thread; a program uses one thread for each, and neither waits for the other. `step` and `contacts` stand for a
   physics engine. */
#include <math.h>
#include <palpate.h>
#include <stdio.h>

#define TOOL 0.01 /* [m] */
#define BALL 0.02 /* [m] */
#define MASS 0.1  /* [kg] */
static double height = BALL, velocity = 0.0;
static const double STIFF = 3000.0, DAMPING = 5.0; /* of the floor */

/* Integrates the engine over `time` [s] under a constant wrench, in sub-steps. */
static void step(const palpate_wrench *wrench, double time) {
  int parts = (int)ceil(time / 1e-4);
  for (int part = 0; part < parts; part++) {
    double pushed = height < BALL ? STIFF * (BALL - height) - DAMPING * velocity : 0.0;
    velocity += time / parts * ((fmax(pushed, 0.0) + wrench->force[2]) / MASS - 9.81);
    height += time / parts * velocity;
  }
}

/* Returns the state of the ball. Its only other load is its weight: the floor is published as a contact. */
static palpate_host_body ball(void) {
  palpate_host_body now = palpate_host_body_fixed(0.0, 0.0, height);
  now.velocity[2] = velocity;
  now.acceleration[2] = -9.81;
  for (int axis = 0; axis < 3; axis++) {
    now.mobility[axis][axis] = 1.0 / MASS;
    now.mobility[axis + 3][axis + 3] = 1.0 / (0.4 * MASS * BALL * BALL);
  }
  return now;
}

/* Potential contacts of the tool with the ball and of the ball with the floor. */
static void contacts(const double tool[3], palpate_host_contact found[2]) {
  double from[3] = {tool[0], tool[1], tool[2] - height}, up[3] = {0.0, 0.0, 1.0}, *normal = from;
  double far = sqrt(from[0] * from[0] + from[1] * from[1] + from[2] * from[2]);
  for (int axis = 0; axis < 3 && far > 0.0; axis++) from[axis] /= far;
  if (far == 0.0) normal = up;
  found[0] = palpate_host_contact_at_gap(tool, TOOL, 0, far - BALL - TOOL, normal, 1500.0);
  found[0].curvature = 1.0 / BALL;
  found[1] = palpate_host_contact_none();
  found[1].normal[2] = 1.0;
  found[1].stiffness = STIFF;
  found[1].damping = DAMPING;
  found[1].of = 0; /* a sphere of the ball on a fixed surface */
  found[1].centre[2] = height;
  found[1].radius = BALL;
}

int main(void) {
  palpate_local_params params = palpate_local_params_default();
  palpate_local_world *world;
  palpate_low_rate_simulator *host;
  palpate_progress progress = palpate_progress_empty();
  palpate_body_progress given, before = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  double place = 0.055, speed = 0.0; /* of the simulated device [m], [m/s] */
  uint64_t stepped = 0;
  params.period = 0.001; /* [s] */
  for (int axis = 0; axis < 3; axis++) params.device_mass[axis] = 0.15; /* [kg] */
  params.tool_radius = TOOL;
  params.bodies = 1;
  params.contacts = 2;
  if (palpate_local_world_new(&params, &world, &host) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  for (int tick = 0; tick < 2000; tick++) {
    palpate_pose pose = {{0.0, 0.0, place}, {1.0, 0.0, 0.0, 0.0}}; /* read your device here [m] */
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
    palpate_wrench wrench;
    if (tick % 20 == 0) { /* the simulator's step */
      palpate_host_body now;
      palpate_host_contact found[2];
      double time;
      palpate_low_rate_simulator_progress(host, &progress, &given, 1);
      time = (double)(progress.tick - stepped) * progress.period;
      if (time > 0.0) {
        palpate_wrench mean = palpate_mean_wrench(&before, &given, time);
        step(&mean, time);
      }
      stepped = progress.tick, before = given;
      now = ball();
      contacts(tick == 0 ? pose.position : progress.position, found);
      if (palpate_low_rate_simulator_publish(host, progress.tick, &now, 1, found, 2)) return puts(palpate_last_error()), 1;
    }
    palpate_local_world_step(world, &sample, &wrench, NULL); /* command wrench.force [N] */
    speed += 0.001 / 0.15 * (60.0 * (0.02 - place) - 1.5 * speed + wrench.force[2]);
    place += 0.001 * speed;
    if (tick % 200 == 199)
      printf("%.1f s: the tool at %5.2f mm, the ball at %5.2f mm, %5.3f N\n", 0.001 * (tick + 1), 1e3 * place, 1e3 * height,
             wrench.force[2]);
  }
  palpate_low_rate_simulator_free(host);
  palpate_local_world_free(world);
  return 0;
}
