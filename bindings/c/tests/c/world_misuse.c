/* Caller errors of a world: each returns a status and a message, and no force. */
#include <math.h>
#include <palpate.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;

static void expect(int line, int holds, const char *what) {
  if (!holds) {
    fprintf(stderr, "world_misuse.c:%d: not so: %s; last error: %s\n", line, what, palpate_last_error());
    failures++;
  }
}
#define EXPECT(condition) expect(__LINE__, (condition), #condition)
#define REFUSED(status, stated, words) \
  EXPECT((status) == (stated) && strstr(palpate_last_error(), (words)) != NULL)

static const char SCENE[] =
    "format = 2\n"
    "[loop]\nperiod_s = 0.001\n"
    "[[device]]\nname = \"tool\"\nmass_kg = 0.2\nposition_m = [0.0, 0.0, 0.02]\n"
    "tool = { sphere = { radius_m = 0.01 } }\n"
    "[[body]]\nname = \"floor\"\nfixed = true\n"
    "shape = { half_space = { normal = [0.0, 0.0, 1.0], offset_m = 0.0 } }\n"
    "[[contact]]\nbetween = [\"*\", \"*\"]\nstiffness_n_per_m = 1000.0\n"
    "[model]\ndevice_mass_kg = 0.2\n"
    "[render]\nmethod = \"basic\"\n";

static void making(void) {
  palpate_world *world = (palpate_world *)1;
  palpate_world_params params = palpate_world_params_default();

  REFUSED(palpate_world_open("there/is/none.toml", NULL, &world), PALPATE_STATUS_SCENE, "there/is/none.toml: ");
  EXPECT(world == NULL);
  REFUSED(palpate_world_open("", NULL, &world), PALPATE_STATUS_SCENE, "path is \"\", but must name a file");
  REFUSED(palpate_world_open(NULL, NULL, &world), PALPATE_STATUS_NULL, "path is NULL");
#ifdef __linux__
  /* An endless file does not fill the memory. */
  REFUSED(palpate_world_open("/dev/zero", NULL, &world), PALPATE_STATUS_SCENE, "/dev/zero: the file is longer than 16 MiB");
#endif
  EXPECT(palpate_world_open("x", NULL, NULL) == PALPATE_STATUS_NULL);
  REFUSED(palpate_world_new("format = 2\nloop = 3\n", "mine.toml", NULL, &world), PALPATE_STATUS_SCENE, "mine.toml:2");
  REFUSED(palpate_world_new("\xff", NULL, NULL, &world), PALPATE_STATUS_SETTING, "scene is not UTF-8");
  params.method = "couple";
  REFUSED(palpate_world_new(SCENE, NULL, &params, &world), PALPATE_STATUS_SETTING,
          "did you mean coupled? Known here: basic, virtual-damper, seh, popc, popc-ref, hfcr-mod, hfcr-mod-st, hfcr, virtual-coupling, god-object, coupled");
  EXPECT(palpate_world_method_count() == 11 && palpate_world_method_name(11) == NULL);
  EXPECT(strcmp(palpate_world_method_name(0), "basic") == 0 && strcmp(palpate_world_method_name(10), "coupled") == 0);
  params = palpate_world_params_default();
  params.force_limit = NAN;
  REFUSED(palpate_world_new(SCENE, NULL, &params, &world), PALPATE_STATUS_PARAMETER,
          "force_limit is NaN, but must be above 0, INFINITY for no limit, or 0 for the scene's");
  params.force_limit = 1e-300;
  REFUSED(palpate_world_new(SCENE, NULL, &params, &world), PALPATE_STATUS_PARAMETER, "has to be at least 1e-20");
  params = palpate_world_params_default();
  params.soft_start = -1.0;
  REFUSED(palpate_world_new(SCENE, NULL, &params, &world), PALPATE_STATUS_PARAMETER, "soft_start is -1");
  params = palpate_world_params_default();
  params.struct_size = 3;
  REFUSED(palpate_world_new(SCENE, NULL, &params, &world), PALPATE_STATUS_STRUCT_SIZE, "palpate_world_params");
  palpate_world_free(NULL);
}

static void ticks(void) {
  palpate_world *world;
  palpate_world_params params = palpate_world_params_default();
  palpate_world_output output = palpate_world_output_empty();
  palpate_body_state state = palpate_body_state_empty();
  palpate_world_ledger ledger = palpate_world_ledger_empty();
  palpate_pose pose = {{0.0, 0.0, 0.009}, {1.0, 0.0, 0.0, 0.0}};
  palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
  palpate_wrench wrenches[2] = {{{9.0, 9.0, 9.0}, {9.0, 9.0, 9.0}, {9.0, 9.0, 9.0}},
                                {{9.0, 9.0, 9.0}, {9.0, 9.0, 9.0}, {9.0, 9.0, 9.0}}};

  params.soft_start = 0.0;
  EXPECT(palpate_world_new(SCENE, NULL, &params, &world) == PALPATE_STATUS_OK);
  EXPECT(palpate_world_device_count(world) == 1 && palpate_world_body_count(world) == 1);
  EXPECT(strcmp(palpate_world_device_name(world, 0), "tool") == 0 && palpate_world_device_name(world, 1) == NULL);
  EXPECT(strcmp(palpate_world_body_name(world, 0), "floor") == 0 && palpate_world_body_name(world, 1) == NULL);
  EXPECT(palpate_world_device_turns(world, 0) == 0 && palpate_world_period(world) == 0.001);

  EXPECT(palpate_world_step(world, &sample, wrenches, 1, &output) == PALPATE_FAULT_NONE);
  EXPECT(fabs(wrenches[0].force[2] - 1.0) < 1e-9 && output.limited == 0);
  /* One wrench too many, no wrench, a missing pose: no force remains from the previous tick. */
  EXPECT(palpate_world_step(world, &sample, wrenches, 2, &output) == PALPATE_FAULT_ARGUMENT);
  EXPECT(strcmp(palpate_last_error(), "wrench_count is 2, but the world has 1 devices") == 0);
  EXPECT(wrenches[0].force[2] == 0.0 && wrenches[1].force[0] == 0.0 && wrenches[1].slope[2] == 0.0);
  EXPECT(output.fault == PALPATE_FAULT_ARGUMENT);
  EXPECT(palpate_world_step(world, &sample, NULL, 1, &output) == PALPATE_FAULT_ARGUMENT);
  EXPECT(palpate_world_step(NULL, &sample, wrenches, 1, &output) == PALPATE_FAULT_ARGUMENT);
  EXPECT(palpate_world_step(world, NULL, wrenches, 1, &output) == PALPATE_FAULT_ARGUMENT);
  sample.poses = NULL;
  EXPECT(palpate_world_step(world, &sample, wrenches, 1, &output) == PALPATE_FAULT_ARGUMENT);
  sample = palpate_world_sample_at(&pose, 0);
  EXPECT(palpate_world_step(world, &sample, wrenches, 1, &output) == PALPATE_FAULT_ARGUMENT);
  sample = palpate_world_sample_at(&pose, 1);
  EXPECT(palpate_world_step(world, &sample, wrenches, 1, &output) == PALPATE_FAULT_NONE);
  EXPECT(wrenches[0].force[2] > 0.9);
  output.struct_size = 8;
  EXPECT(palpate_world_step(world, &sample, wrenches, 1, &output) == PALPATE_FAULT_ARGUMENT);
  EXPECT(wrenches[0].force[2] == 0.0);

  output = palpate_world_output_empty();
  pose.position[0] = INFINITY;
  EXPECT(palpate_world_step(world, &sample, wrenches, 1, &output) == PALPATE_FAULT_POSITION_NOT_FINITE);
  EXPECT(output.fault_device == 0 && wrenches[0].force[2] == 0.0);
  /* The default force limit equals that of the program. */
  pose.position[0] = 0.0;
  pose.position[2] = -0.04;
  EXPECT(palpate_world_step(world, &sample, wrenches, 1, &output) == PALPATE_FAULT_NONE);
  EXPECT(fabs(wrenches[0].force[2] - 20.0) < 1e-9 && output.limited == PALPATE_LIMIT_FORCE);

  EXPECT(palpate_world_body_state(world, 0, &state) == PALPATE_STATUS_OK && state.velocity[0] == 0.0);
  REFUSED(palpate_world_body_state(world, 1, &state), PALPATE_STATUS_COUNT, "body is 1, but must be less than 1");
  REFUSED(palpate_world_report_sent(world, 1, wrenches), PALPATE_STATUS_COUNT, "device is 1, but must be less than 1");
  EXPECT(palpate_world_ledger_of(world, &ledger) == PALPATE_STATUS_OK && ledger.stored > 0.0 && ledger.dissipated == 0.0);
  EXPECT(palpate_world_ledger_of(world, NULL) == PALPATE_STATUS_NULL);
  palpate_world_free(world);
}

/* Rejected calls leave a world unchanged. */
static void refused_ticks(void) {
  palpate_world *world, *left_alone;
  palpate_world_output output = palpate_world_output_empty(), small = output;
  palpate_world_ledger ledger = palpate_world_ledger_empty(), expected = ledger;
  palpate_wrench wrench, other, wrong = {{NAN, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};

  small.struct_size = sizeof small - 1;
  EXPECT(palpate_world_new(SCENE, NULL, NULL, &world) == PALPATE_STATUS_OK);
  EXPECT(palpate_world_new(SCENE, NULL, NULL, &left_alone) == PALPATE_STATUS_OK);
  for (int tick = 0; tick < 50; tick++) {
    palpate_pose pose = {{0.0, 0.0, 0.01 - 2e-5 * tick}, {1.0, 0.0, 0.0, 0.0}};
    palpate_world_sample sample = palpate_world_sample_at(&pose, 1), reserved = sample, flag = sample;
    reserved.reserved = 7, flag.has_elapsed = 2;
    EXPECT(palpate_world_step(left_alone, &sample, &other, 1, NULL) == PALPATE_FAULT_NONE);
    wrench.force[2] = 1.0;
    EXPECT(palpate_world_step(world, &sample, &wrench, 1, &small) == PALPATE_FAULT_ARGUMENT && wrench.force[2] == 0.0);
    EXPECT(strstr(palpate_last_error(), "struct_size of palpate_world_output is ") != NULL);
    EXPECT(palpate_world_step(world, &sample, NULL, 1, &output) == PALPATE_FAULT_ARGUMENT);
    EXPECT(strcmp(palpate_last_error(), "wrenches is NULL") == 0 && output.fault == PALPATE_FAULT_ARGUMENT);
    EXPECT(palpate_world_step(world, &sample, &wrench, SIZE_MAX, &output) == PALPATE_FAULT_ARGUMENT);
    EXPECT(palpate_world_step(world, &reserved, &wrench, 1, &output) == PALPATE_FAULT_ARGUMENT);
    EXPECT(strcmp(palpate_last_error(), "reserved is 7, but must be 0") == 0);
    EXPECT(palpate_world_step(world, &flag, &wrench, 1, &output) == PALPATE_FAULT_ARGUMENT);
    EXPECT(palpate_world_step(world, &sample, &wrench, 1, &output) == PALPATE_FAULT_NONE);
    EXPECT(memcmp(&wrench, &other, sizeof wrench) == 0);
    REFUSED(palpate_world_report_sent(world, 0, &wrong), PALPATE_STATUS_PARAMETER, "force is NaN, but must be finite [N]");
    EXPECT(palpate_world_ledger_of(world, &ledger) == PALPATE_STATUS_OK);
    EXPECT(palpate_world_ledger_of(left_alone, &expected) == PALPATE_STATUS_OK);
    EXPECT(memcmp(&ledger, &expected, sizeof ledger) == 0);
  }
  EXPECT(wrench.force[2] > 0.0 && ledger.port_work != 0.0);
  wrong.force[0] = 0.0, wrong.torque[1] = INFINITY;
  REFUSED(palpate_world_report_sent(world, 0, &wrong), PALPATE_STATUS_PARAMETER, "torque is inf, but must be finite [N m]");
  palpate_world_free(world);
  palpate_world_free(left_alone);
}

/* A held 2 N generates 4 mJ in every second period while the device retracts by 2 mm: a safety stop. */
static void created_energy(void) {
  palpate_world *world;
  palpate_world_params params = palpate_world_params_default();
  palpate_world_output output = palpate_world_output_empty();
  palpate_pose pose = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}};
  palpate_world_sample sample = palpate_world_sample_at(&pose, 1);
  palpate_wrench wrench;
  int tick, pushed = 0;

  params.soft_start = 0.0;
  EXPECT(palpate_world_new(SCENE, NULL, &params, &world) == PALPATE_STATUS_OK);
  for (tick = 0; tick < 100; tick++) {
    pose.position[2] = tick % 2 == 0 ? 0.008 : 0.01;
    EXPECT(palpate_world_step(world, &sample, &wrench, 1, &output) == PALPATE_FAULT_NONE);
    pushed += wrench.force[2] > 1.0;
    EXPECT(tick < 40 || wrench.force[2] == 0.0);
  }
  EXPECT(pushed >= 10 && pushed < 20);
  EXPECT((output.limited & PALPATE_LIMIT_STOPPED) != 0);
  palpate_world_free(world);
}

int main(void) {
  making();
  ticks();
  refused_ticks();
  created_energy();
  return failures != 0;
}
