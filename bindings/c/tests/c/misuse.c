/* Caller errors: each returns a status and a message, and no force. */
#include <math.h>
#include <palpate.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

static void expect(int line, int holds, const char *what) {
  if (!holds) {
    fprintf(stderr, "misuse.c:%d: not so: %s; last error: %s\n", line, what, palpate_last_error());
    failures++;
  }
}
#define EXPECT(condition) expect(__LINE__, (condition), #condition)
#define REFUSED(status, stated, words) \
  EXPECT((status) == (stated) && strcmp(palpate_last_error(), (words)) == 0)

static palpate_loop_params loop_params(void) {
  palpate_loop_params loop = palpate_loop_params_default();
  loop.period = 0.001;
  return loop;
}

static palpate_contact_params basic_params(void) {
  palpate_contact_params params = palpate_contact_params_default();
  params.method = "basic";
  params.stiffness = 1000.0;
  return params;
}

static void parameters(void) {
  palpate_contact *contact;
  palpate_loop_params loop = loop_params();
  palpate_contact_params params = basic_params();
  palpate_setting setting = {"damping_n_s_per_m", -1.0, NULL};
  const palpate_setting twice[] = {{"damping_n_s_per_m", 0.5, NULL}, {"damping_n_s_per_m", 0.5, NULL}};

  params.stiffness = -400.0;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "stiffness is -400 N/m, but must be finite and greater than 0");
  EXPECT(contact == NULL);
  params = basic_params();
  loop.period = 0.0;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "period is 0 s, but must be finite and greater than 0");
  loop = loop_params();
  loop.gain = 0.0;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "gain is 0, but must be finite and greater than 0");
  loop = loop_params();
  loop.device_mass = NAN;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "device_mass is NaN kg, but must be greater than 0, or 0 if unknown");
  loop = loop_params();
  loop.guard = 3;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "guard is 3, but must be PALPATE_GUARD_OFF, PALPATE_GUARD_REPORT or PALPATE_GUARD_LIMIT");
  loop = loop_params();
  params.side = 7;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "side is 7, but must be PALPATE_SIDE_POSITIVE or PALPATE_SIDE_NEGATIVE");
  params = basic_params();
  params.method = NULL;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_SETTING,
          "coupled needs the device's effective mass, within a factor of 2");
  params.method = "copled";
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_SETTING,
          "no method is called \"copled\"; there are basic, seh, virtual-damper, popc, popc-ref, "
          "energy-corrected, force-bounding, pmi, energy-tank, virtual-coupling, "
          "hfcr-mod, hfcr-mod-st, hfcr, coupled");
  params.method = "\xff";
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_SETTING, "method is not UTF-8");
  params.method = "virtual-damper";
  params.settings = &setting;
  params.setting_count = 1;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "damping is -1 N s/m, but must be finite and not below 0");
  setting.key = "damping";
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_SETTING,
          "virtual-damper has no setting \"damping\"; it has damping_n_s_per_m, prediction, "
          "damper_object, longest_window_s");
  setting.key = "damper_object";
  setting.word = "by guess";
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_SETTING,
          "damper_object is \"by guess\", but must be \"spring-and-damper\", \"spring\" or \"held-force\"");
  setting.word = NULL;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_SETTING,
          "damper_object is a number, but must be \"spring-and-damper\", \"spring\" or \"held-force\"");
  setting.key = NULL;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_NULL, "key of a setting is NULL");
  params.settings = NULL;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_NULL, "settings is NULL");
  params.settings = twice;
  params.setting_count = 2;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_SETTING, "damping_n_s_per_m is given twice");
  params = basic_params();
  params.unilateral = 2;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER, "unilateral is 2, but must be 0 or 1");
  params = basic_params();
  loop.hold = 2;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "hold is 2, but must be PALPATE_HOLD_CONSTANT or PALPATE_HOLD_LINE");
  loop.hold = PALPATE_HOLD_LINE;
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_PARAMETER,
          "order of the hold is 1, but must be 0, a constant: of the methods, only coupled plans a line");
}

static void structs(void) {
  struct {
    palpate_contact_params known;
    double unknown;
  } newer;
  palpate_contact *contact;
  palpate_loop_params loop = loop_params();
  palpate_contact_params params = basic_params();
  char words[200];

  REFUSED(palpate_contact_new(NULL, &loop, &contact), PALPATE_STATUS_NULL, "palpate_contact_params is NULL");
  REFUSED(palpate_contact_new(&params, NULL, &contact), PALPATE_STATUS_NULL, "palpate_loop_params is NULL");
  REFUSED(palpate_contact_new(&params, &loop, NULL), PALPATE_STATUS_NULL, "contact is NULL");
  params.struct_size = 0;
  snprintf(words, sizeof words,
           "struct_size of palpate_contact_params is 0, but must be at least %zu: "
           "the function that the header names at this field sets it",
           sizeof params);
  REFUSED(palpate_contact_new(&params, &loop, &contact), PALPATE_STATUS_STRUCT_SIZE, words);

  /* A program compiled with a newer header. */
  EXPECT(palpate_contact_params_init(&newer.known, sizeof newer) == PALPATE_STATUS_OK);
  EXPECT(newer.unknown == 0.0 && newer.known.struct_size == sizeof newer);
  newer.known.method = "basic";
  newer.known.stiffness = 1000.0;
  EXPECT(palpate_contact_new(&newer.known, &loop, &contact) == PALPATE_STATUS_OK);
  palpate_contact_free(contact);
  newer.unknown = 1.0;
  snprintf(words, sizeof words,
           "struct_size of palpate_contact_params is %zu, but this library knows %zu bytes; the bytes beyond "
           "must be 0",
           sizeof newer, sizeof params);
  REFUSED(palpate_contact_new(&newer.known, &loop, &contact), PALPATE_STATUS_STRUCT_SIZE, words);
}

static void ticks(void) {
  palpate_contact *contact;
  palpate_loop_params loop = loop_params();
  palpate_contact_params params = basic_params();
  palpate_sample sample = palpate_sample_at(0.001);
  palpate_output output = palpate_output_empty();
  palpate_ledger ledger = palpate_ledger_empty();

  EXPECT(palpate_contact_step(NULL, &sample, &output) == 0.0);
  EXPECT(output.fault == PALPATE_FAULT_ARGUMENT && output.phase == PALPATE_PHASE_WAITING);
  EXPECT(palpate_contact_step(NULL, NULL, NULL) == 0.0);
  EXPECT(palpate_contact_report_sent(NULL, 1.0) == PALPATE_STATUS_NULL);
  EXPECT(palpate_contact_ledger(NULL, &ledger) == PALPATE_STATUS_NULL);
  EXPECT(palpate_contact_describe(NULL, NULL, 0) == 0);
  palpate_contact_free(NULL);

  EXPECT(palpate_contact_new(&params, &loop, &contact) == PALPATE_STATUS_OK);
  EXPECT(palpate_contact_step(contact, &sample, &output) == -1.0);
  EXPECT(output.force_on_device == -1.0 && output.fault == PALPATE_FAULT_NONE);
  EXPECT(palpate_contact_step(contact, NULL, &output) == 0.0 && output.fault == PALPATE_FAULT_ARGUMENT);
  sample.struct_size = 1;
  EXPECT(palpate_contact_step(contact, &sample, &output) == 0.0 && output.fault == PALPATE_FAULT_ARGUMENT);
  sample = palpate_sample_at(NAN);
  EXPECT(palpate_contact_step(contact, &sample, &output) == 0.0);
  EXPECT(output.fault == PALPATE_FAULT_POSITION_NOT_FINITE);
  sample = palpate_sample_at(0.001);
  output.struct_size = 8;
  EXPECT(palpate_contact_step(contact, &sample, &output) == 0.0);
  EXPECT(palpate_contact_ledger(contact, NULL) == PALPATE_STATUS_NULL);
  EXPECT(palpate_contact_teleport(contact, NAN, 0.0) == PALPATE_STATUS_PARAMETER);
  /* The default force limit equals that of the program. */
  sample = palpate_sample_at(0.05);
  output = palpate_output_empty();
  EXPECT(palpate_contact_step(contact, &sample, &output) == -20.0);
  EXPECT(output.limited == PALPATE_LIMIT_FORCE);

  loop.period = 0.002;
  REFUSED(palpate_contact_change(contact, &params, &loop), PALPATE_STATUS_CHANGE,
          "the period is 0.002 s, and the loop runs at 0.001 s; stop the loop to change its period");
  palpate_contact_free(contact);
}

/* Rejected calls leave a contact unchanged. */
static void refused_ticks(void) {
  palpate_contact *contact, *left_alone;
  palpate_loop_params loop = loop_params();
  palpate_contact_params params = basic_params();
  palpate_output output = palpate_output_empty(), small = output;
  palpate_ledger ledger = palpate_ledger_empty(), expected = ledger;

  small.struct_size = sizeof small - 1;
  EXPECT(palpate_contact_new(&params, &loop, &contact) == PALPATE_STATUS_OK);
  EXPECT(palpate_contact_new(&params, &loop, &left_alone) == PALPATE_STATUS_OK);
  for (int tick = 0; tick < 5; tick++) {
    palpate_sample sample = palpate_sample_at(1e-4 * tick), wrong = sample;
    double force = palpate_contact_step(left_alone, &sample, NULL);
    EXPECT(palpate_contact_step(contact, &sample, &small) == 0.0);
    EXPECT(strstr(palpate_last_error(), "struct_size of palpate_output is ") != NULL);
    wrong.reserved = 7;
    EXPECT(palpate_contact_step(contact, &wrong, &output) == 0.0 && output.fault == PALPATE_FAULT_ARGUMENT);
    EXPECT(strcmp(palpate_last_error(), "reserved is 7, but must be 0") == 0);
    wrong = sample;
    wrong.has_elapsed = 2;
    EXPECT(palpate_contact_step(contact, &wrong, &output) == 0.0 && output.fault == PALPATE_FAULT_ARGUMENT);
    EXPECT(strcmp(palpate_last_error(), "has_elapsed is 2, but must be 0 or 1") == 0);
    EXPECT(palpate_contact_step(contact, &sample, &output) == force);
    REFUSED(palpate_contact_report_sent(contact, NAN), PALPATE_STATUS_PARAMETER,
            "force_on_device is NaN, but must be finite [N]");
    REFUSED(palpate_contact_report_held(contact, -INFINITY), PALPATE_STATUS_PARAMETER,
            "force_on_device is -inf, but must be finite [N]");
    EXPECT(palpate_contact_ledger(contact, &ledger) == PALPATE_STATUS_OK);
    EXPECT(palpate_contact_ledger(left_alone, &expected) == PALPATE_STATUS_OK);
    EXPECT(memcmp(&ledger, &expected, sizeof ledger) == 0);
  }
  EXPECT(ledger.port_work != 0.0);
  palpate_contact_free(contact);
  palpate_contact_free(left_alone);
}

static void names(void) {
  char words[100];
  EXPECT(strcmp(palpate_status_name(PALPATE_STATUS_OK), "ok") == 0);
  EXPECT(strcmp(palpate_status_name(PALPATE_STATUS_STRUCT_SIZE), "struct-size") == 0);
  EXPECT(strcmp(palpate_status_name(99), "unknown") == 0);
  EXPECT(strcmp(palpate_fault_name(PALPATE_FAULT_GAP_TOO_LONG), "gap-too-long") == 0);
  EXPECT(strcmp(palpate_fault_name(PALPATE_FAULT_ARGUMENT), "argument") == 0);
  EXPECT(strcmp(palpate_fault_name(50), "unknown") == 0);
  /* The setting damper_object of the method virtual-damper accepts words, longest_window_s none. */
  palpate_setting_text(2, 2, PALPATE_ABOUT_SETTING_WORDS, words, sizeof words);
  EXPECT(strcmp(words, "spring-and-damper, spring, held-force") == 0);
  EXPECT(palpate_setting_text(2, 3, PALPATE_ABOUT_SETTING_WORDS, words, sizeof words) == 0 && strcmp(words, "") == 0);
}

static void memory(void) {
  palpate_contact *contact;
  palpate_loop_params loop = loop_params();
  palpate_contact_params params = basic_params();
  size_t size = palpate_contact_size();
  char *bytes = malloc(size + palpate_contact_align());
  char words[100];
  char text[8];

  EXPECT(size <= PALPATE_CONTACT_SIZE_MAX && palpate_contact_align() <= PALPATE_CONTACT_ALIGN_MAX);
  snprintf(words, sizeof words, "the memory has %zu bytes, but must have %zu", size - 1, size);
  REFUSED(palpate_contact_place(bytes, size - 1, &params, &loop, &contact), PALPATE_STATUS_MEMORY, words);
  EXPECT(palpate_contact_place(bytes + 1, size, &params, &loop, &contact) == PALPATE_STATUS_MEMORY);
  EXPECT(palpate_contact_place(NULL, size, &params, &loop, &contact) == PALPATE_STATUS_NULL);
  EXPECT(palpate_contact_place(bytes, size, &params, &loop, &contact) == PALPATE_STATUS_OK);
  EXPECT(contact != NULL);
  EXPECT(palpate_contact_describe(contact, text, sizeof text) == strlen("a wall of 1000 N/m, f_V 0 N, by basic"));
  EXPECT(strcmp(text, "a wall ") == 0);
  palpate_contact_free(contact); /* the caller owns the memory */
  free(bytes);
}

int main(void) {
  EXPECT(palpate_abi_version() == PALPATE_ABI_VERSION);
  EXPECT(strcmp(palpate_last_error(), "") == 0);
  parameters();
  structs();
  ticks();
  refused_ticks();
  names();
  memory();
  return failures != 0;
}
