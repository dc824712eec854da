/* Local models: caller errors, and both sides in two threads. */
#include <math.h>
#include <palpate.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

static void expect(int line, int holds, const char *what) {
  if (!holds) {
    fprintf(stderr, "local.c:%d: not so: %s; last error: %s\n", line, what, palpate_last_error());
    failures++;
  }
}
#define EXPECT(condition) expect(__LINE__, (condition), #condition)
#define REFUSED(status, stated, words) \
  EXPECT((status) == (stated) && strstr(palpate_last_error(), (words)) != NULL)

static const double UP[3] = {0.0, 0.0, 1.0};

static palpate_local_params right(void) {
  palpate_local_params params = palpate_local_params_default();
  params.period = 0.001;
  params.device_mass[0] = params.device_mass[1] = params.device_mass[2] = 0.2;
  params.tool_radius = 0.005;
  params.soft_start = 0.0;
  return params;
}

static void making(void) {
  palpate_local_world *world = (palpate_local_world *)1;
  palpate_low_rate_simulator *host = (palpate_low_rate_simulator *)1;
  palpate_local_params params = palpate_local_params_default();
#define REFUSES(change, stated, words)                                        \
  params = right();                                                           \
  change;                                                                     \
  REFUSED(palpate_local_world_new(&params, &world, &host), (stated), (words)); \
  EXPECT(world == NULL && host == NULL)
  REFUSES(params = palpate_local_params_default(), PALPATE_STATUS_PARAMETER, "period is 0, but must be finite and greater");
  REFUSES(params.device_mass[1] = 0.0, PALPATE_STATUS_PARAMETER, "device_mass is 0, but must be greater than 0, or INFINITY");
  REFUSES(params.device_mass[2] = NAN, PALPATE_STATUS_PARAMETER, "device_mass is NaN");
  REFUSES(params.device_mass[0] = params.device_mass[1] = params.device_mass[2] = INFINITY, PALPATE_STATUS_PARAMETER,
          "the device must have one");
  REFUSES(params.tool_radius = -1.0, PALPATE_STATUS_PARAMETER, "radius");
  REFUSES(params.contacts = 0, PALPATE_STATUS_PARAMETER, "contacts is 0, and has to be 1 to 64");
  REFUSES(params.bodies = 17, PALPATE_STATUS_PARAMETER, "bodies is 17, and at most 16 are allowed");
  REFUSES(params.stale_after = 5.0, PALPATE_STATUS_PARAMETER, "stale_after is 5 s");
  REFUSES(params.delay = -1.0, PALPATE_STATUS_PARAMETER, "delay");
  REFUSES(params.force_limit = 0.0, PALPATE_STATUS_PARAMETER, "force_limit is 0, but must be above 0, or INFINITY");
  REFUSES(params.soft_start = -1.0, PALPATE_STATUS_PARAMETER, "soft_start is -1");
  REFUSES(params.struct_size = 3, PALPATE_STATUS_STRUCT_SIZE, "palpate_local_params");
  params = right();
  host = (palpate_low_rate_simulator *)1;
  EXPECT(palpate_local_world_new(&params, NULL, &host) == PALPATE_STATUS_NULL && host == NULL);
  EXPECT(palpate_local_world_new(&params, &world, NULL) == PALPATE_STATUS_NULL && world == NULL);
  EXPECT(palpate_local_world_new(NULL, &world, &host) == PALPATE_STATUS_NULL);
  palpate_local_world_free(NULL);
  palpate_low_rate_simulator_free(NULL);
}

/* Executes a tick with the tool at the given depth in a floor at 0. */
static palpate_fault tick(palpate_local_world *world, double depth, palpate_wrench *wrench, palpate_local_output *output) {
  palpate_pose pose = {{0.0, 0.0, 0.005 - depth}, {0.0, 0.0, 0.0, 0.0}};
  palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
  return palpate_local_world_step(world, &sample, wrench, output);
}

static void ticks(void) {
  palpate_local_world *world;
  palpate_low_rate_simulator *host;
  palpate_local_params params = right();
  palpate_local_output output = palpate_local_output_empty();
  palpate_progress progress = palpate_progress_empty();
  palpate_wrench wrench = {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}, {7.0, 8.0, 9.0}};
  palpate_host_body body = palpate_host_body_fixed(0.0, 0.0, 0.0);
  palpate_host_contact floor[2];
  const double centre[3] = {0.0, 0.0, 0.005};
  palpate_pose pose = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
  palpate_body_progress given[1];
  uint64_t before;
  floor[0] = palpate_host_contact_at_gap(centre, 0.005, PALPATE_NO_BODY, 0.0, UP, 1000.0);
  floor[1] = palpate_host_contact_none();
  params.contacts = 2;
  EXPECT(palpate_local_world_new(&params, &world, &host) == PALPATE_STATUS_OK);

  EXPECT(tick(world, 0.001, &wrench, &output) == PALPATE_FAULT_NONE && wrench.force[2] == 0.0 && wrench.torque[2] == 0.0);
  EXPECT(output.is_stale == 1 && output.age == INFINITY && output.refusal == PALPATE_MODEL_REFUSAL_NONE);
  /* Longer than the maximum age of a model. */
  for (int at = 0; at < 400; at++) {
    EXPECT(palpate_low_rate_simulator_progress(host, &progress, NULL, 0) == PALPATE_STATUS_OK);
    EXPECT(palpate_low_rate_simulator_publish(host, progress.tick, NULL, 0, floor, 2) == PALPATE_STATUS_OK);
    EXPECT(tick(world, 0.001, &wrench, &output) == PALPATE_FAULT_NONE);
  }
  EXPECT(fabs(wrench.force[2] - 1.0) < 0.05 && wrench.force[0] == 0.0 && output.is_stale == 0);
  EXPECT(fabs(output.age - 0.001) < 1e-12 && progress.tick == 400 && progress.has_model == 1 && progress.model_tick == 399);
  EXPECT(progress.period == 0.001 && fabs(progress.position[2] - 0.004) < 0.001);

  /* An invalid model changes nothing, and the message lists all faults. */
  REFUSED(palpate_low_rate_simulator_publish(host, 400, &body, 1, floor, 1), PALPATE_STATUS_COUNT,
          "body_count is 1, but the local model has 0 bodies");
  REFUSED(palpate_low_rate_simulator_publish(host, 400, NULL, 0, NULL, 1), PALPATE_STATUS_NULL, "contacts is NULL");
  floor[0].normal[2] = 0.5, floor[1] = floor[0], floor[1].normal[2] = 1.0, floor[1].on = 3;
  REFUSED(palpate_low_rate_simulator_publish(host, 400, NULL, 0, floor, 2), PALPATE_STATUS_PARAMETER, "contact 0");
  REFUSED(palpate_low_rate_simulator_publish(host, 400, NULL, 0, floor, 2), PALPATE_STATUS_PARAMETER, "contact 1");
  floor[0].normal[2] = 1.0, floor[0].stiffness = NAN;
  REFUSED(palpate_low_rate_simulator_publish(host, 400, NULL, 0, floor, 1), PALPATE_STATUS_PARAMETER, "contact 0");
  floor[0].stiffness = 1000.0, floor[1] = palpate_host_contact_none();
  REFUSED(palpate_low_rate_simulator_progress(host, &progress, given, 1), PALPATE_STATUS_COUNT, "body_count is 1");
  REFUSED(palpate_low_rate_simulator_progress(host, NULL, NULL, 0), PALPATE_STATUS_NULL, "palpate_progress");
  EXPECT(palpate_low_rate_simulator_progress(NULL, &progress, NULL, 0) == PALPATE_STATUS_NULL);
  EXPECT(palpate_low_rate_simulator_publish(NULL, 0, NULL, 0, NULL, 0) == PALPATE_STATUS_NULL);
  /* Both sides report a model that the loop rejects. */
  EXPECT(palpate_low_rate_simulator_publish(host, 5000, NULL, 0, floor, 2) == PALPATE_STATUS_OK);
  EXPECT(tick(world, 0.001, &wrench, &output) == PALPATE_FAULT_NONE && output.refusal == PALPATE_MODEL_REFUSAL_NOT_YET);
  EXPECT(palpate_low_rate_simulator_progress(host, &progress, NULL, 0) == PALPATE_STATUS_OK);
  EXPECT(progress.refusal == PALPATE_MODEL_REFUSAL_NOT_YET && fabs(wrench.force[2] - 1.0) < 0.05);

  /* An invalid sample gives no force. */
  EXPECT(tick(world, NAN, &wrench, &output) == PALPATE_FAULT_POSITION_NOT_FINITE && wrench.force[2] == 0.0);
  wrench.force[2] = 1.0;
  EXPECT(palpate_local_world_step(NULL, &sample, &wrench, NULL) == PALPATE_FAULT_ARGUMENT && wrench.force[2] == 0.0);
  wrench.force[2] = 1.0;
  EXPECT(palpate_local_world_step(world, NULL, &wrench, NULL) == PALPATE_FAULT_ARGUMENT && wrench.force[2] == 0.0);
  EXPECT(palpate_local_world_step(world, &sample, NULL, NULL) == PALPATE_FAULT_ARGUMENT);
  sample.pose_count = 2;
  EXPECT(palpate_local_world_step(world, &sample, &wrench, NULL) == PALPATE_FAULT_ARGUMENT);
  sample = palpate_world_sample_at(NULL, 1);
  EXPECT(palpate_local_world_step(world, &sample, &wrench, NULL) == PALPATE_FAULT_ARGUMENT);
  /* A tick whose output struct is invalid is not executed. */
  EXPECT(palpate_low_rate_simulator_progress(host, &progress, NULL, 0) == PALPATE_STATUS_OK);
  before = progress.tick;
  output.struct_size = 8;
  EXPECT(tick(world, 0.001, &wrench, &output) == PALPATE_FAULT_ARGUMENT && wrench.force[2] == 0.0);
  EXPECT(palpate_low_rate_simulator_progress(host, &progress, NULL, 0) == PALPATE_STATUS_OK && progress.tick == before);
  EXPECT(tick(world, 0.001, &wrench, NULL) == PALPATE_FAULT_NONE);
  EXPECT(palpate_low_rate_simulator_progress(host, &progress, NULL, 0) == PALPATE_STATUS_OK && progress.tick == before + 1);
  wrench.force[1] = NAN;
  REFUSED(palpate_local_world_report_sent(world, &wrench), PALPATE_STATUS_PARAMETER, "force is NaN, but must be finite [N]");
  wrench.force[1] = 0.0;
  EXPECT(palpate_local_world_report_sent(world, NULL) == PALPATE_STATUS_NULL);
  EXPECT(palpate_local_world_report_sent(NULL, &wrench) == PALPATE_STATUS_NULL);
  EXPECT(palpate_local_world_report_sent(world, &wrench) == PALPATE_STATUS_OK);

  /* After the simulator side is freed, its contacts fade out. */
  output = palpate_local_output_empty();
  palpate_low_rate_simulator_free(host);
  for (int at = 0; at < 400; at++) tick(world, 0.001, &wrench, &output);
  EXPECT(wrench.force[2] == 0.0 && output.is_stale == 1);
  palpate_local_world_free(world);
}

/* A device without a z axis, which a floor below it cannot push. */
static void planar(void) {
  palpate_local_world *world;
  palpate_low_rate_simulator *host;
  palpate_local_params params = right();
  palpate_wrench wrench;
  palpate_host_contact floor;
  const double centre[3] = {0.0, 0.0, 0.005}, slope[3] = {0.6, 0.0, 0.8};
  params.device_mass[2] = INFINITY;
  floor = palpate_host_contact_at_gap(centre, 0.005, PALPATE_NO_BODY, -0.001, slope, 1000.0);
  EXPECT(palpate_local_world_new(&params, &world, &host) == PALPATE_STATUS_OK);
  for (int at = 0; at < 200; at++) {
    EXPECT(palpate_low_rate_simulator_publish(host, (uint64_t)at, NULL, 0, &floor, 1) == PALPATE_STATUS_OK);
    EXPECT(tick(world, 0.0, &wrench, NULL) == PALPATE_FAULT_NONE);
  }
  EXPECT(wrench.force[0] > 0.4 && wrench.force[2] == 0.0);
  palpate_local_world_free(world);
  EXPECT(palpate_low_rate_simulator_publish(host, 0, NULL, 0, &floor, 1) == PALPATE_STATUS_OK);
  palpate_low_rate_simulator_free(host);
}

static atomic_int published = 0, is_over = 0, is_gone = 0;

static int publish_until_the_end(palpate_low_rate_simulator *host) {
  palpate_progress progress = palpate_progress_empty();
  palpate_body_progress given[1];
  palpate_host_body body = palpate_host_body_fixed(0.0, 0.0, 0.0);
  const double centre[3] = {0.0, 0.0, 0.005};
  palpate_host_contact floor = palpate_host_contact_at_gap(centre, 0.005, 0, 0.0, UP, 1000.0);
  do {
    if (palpate_low_rate_simulator_progress(host, &progress, given, 1) != PALPATE_STATUS_OK) return 1;
    /* This loop does not pace its ticks, so a model can be too old on arrival. No other error is allowed. */
    if (progress.refusal != PALPATE_MODEL_REFUSAL_NONE && progress.refusal != PALPATE_MODEL_REFUSAL_TOO_OLD) return 1;
    if (palpate_low_rate_simulator_publish(host, progress.tick, &body, 1, &floor, 1) != PALPATE_STATUS_OK) return 1;
    published++;
  } while (!is_over);
  return 0;
}

static void *publishes(void *host) {
  int failed = publish_until_the_end(host);
  EXPECT(!failed);
  is_gone = failed;
  return NULL;
}

static void two_threads(void) {
  palpate_local_world *world;
  palpate_low_rate_simulator *host;
  palpate_local_params params = right();
  palpate_local_output output = palpate_local_output_empty();
  palpate_wrench wrench = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
  pthread_t thread;
  params.bodies = 1;
  EXPECT(palpate_local_world_new(&params, &world, &host) == PALPATE_STATUS_OK);
  EXPECT(pthread_create(&thread, NULL, publishes, host) == 0);
  /* Until many models have been published and at least one has been accepted. */
  for (int taken = 0; (published < 100 || !taken) && !is_gone; taken |= !output.is_stale) {
    EXPECT(tick(world, 0.001, &wrench, &output) == PALPATE_FAULT_NONE);
    EXPECT(wrench.force[0] == 0.0 && wrench.force[2] >= 0.0 && wrench.force[2] <= 20.0);
  }
  is_over = 1;
  EXPECT(pthread_join(thread, NULL) == 0 && published >= 100);
  palpate_low_rate_simulator_free(host);
  palpate_local_world_free(world);
}

int main(void) {
  making();
  ticks();
  planar();
  two_threads();
  return failures != 0;
}
