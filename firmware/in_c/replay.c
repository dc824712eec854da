/* Firmware in C that renders the committed trace in float by both methods on a block and on a wall, from the library for
   firmware. It prints every tick's bits, as board/src/replay.rs does from Rust; with -DCOUNT its instructions. */
#include <palpate.h>

#include "board.h"

/* Bits of a sample, and whether its time was measured: samples.h is made of trace/trace.csv. */
static const struct {
  uint32_t device_position, elapsed, virtual_force, has_elapsed;
} samples[] = {
#include "samples.h"
};

enum { SAMPLE_COUNT = sizeof samples / sizeof samples[0], LONGEST_LINE = 256 };

static _Alignas(PALPATE_CONTACT_ALIGN_MAX) unsigned char memory[PALPATE_CONTACT_F32_SIZE_MAX];
static char line[LONGEST_LINE];
static size_t filled;

static void put_byte(char byte) {
  if (filled + 1 < sizeof line) line[filled++] = byte;
}

static void put(const char *text) {
  while (*text != '\0') put_byte(*text++);
}

static void put_number(uint32_t number) {
  if (number >= 10) put_number(number / 10);
  put_byte((char)('0' + number % 10));
}

static void put_bits(float number) {
  const union {
    float number;
    uint32_t bits;
  } is = {number};
  put_byte(' ');
  for (int shift = 28; shift >= 0; shift -= 4) put_byte("0123456789abcdef"[is.bits >> shift & 0xf]);
}

static void end_line(void) {
  line[filled] = '\0';
  say(line);
  say("\n");
  filled = 0;
}

static float of_bits(uint32_t bits) {
  const union {
    uint32_t bits;
    float number;
  } is = {bits};
  return is.number;
}

static const char *phase_name(palpate_phase phase) {
  static const char *const names[] = {"free", "contact", "enters", "leaves", "waiting"};
  return phase <= PALPATE_PHASE_WAITING ? names[phase] : "?";
}

static const char *fault_name(palpate_fault fault) {
  static const char *const names[] = {
      "-",           "position-not-finite", "virtual-force-not-finite", "elapsed-not-positive", "gap-too-long",
      "jump-too-fast", "overflow",
  };
  return fault <= PALPATE_FAULT_OVERFLOW ? names[fault] : "?";
}

#ifdef COUNT
enum { COUNTING = 1 };
#else
enum { COUNTING = 0 };
#endif

static void show_count(const char *name, uint32_t tick, const palpate_output_f32 *output, uint32_t instructions) {
  put("count "), put(name), put_byte(' '), put_number(tick), put_byte(' '), put(phase_name(output->phase));
  /* Its stack is not measured. */
  put_byte(' '), put_number(instructions), put(" 0");
  end_line();
}

static void show_tick(const char *name, uint32_t tick, const palpate_output_f32 *output) {
  put(name), put_byte(' '), put_number(tick);
  put_bits(output->force_on_device);
  put_bits(output->object_position);
  put_bits(output->object_velocity);
  put_bits(output->penetration);
  put_bits(output->transition_after);
  put_byte(' '), put(phase_name(output->phase)), put_byte(' ');
  put_byte(output->limited & PALPATE_LIMIT_PULL ? 'p' : '-');
  put_byte(output->limited & PALPATE_LIMIT_FORCE ? 'f' : '-');
  put_byte(output->limited & PALPATE_LIMIT_SLEW ? 's' : '-');
  put_byte(output->limited & PALPATE_LIMIT_GUARD ? 'g' : '-');
  put_byte(' '), put(fault_name(output->fault));
  end_line();
}

static void show_ledger(const char *name, const palpate_contact_f32 *contact) {
  palpate_ledger_f32 ledger = palpate_ledger_f32_empty();
  palpate_contact_f32_ledger(contact, &ledger);
  put(name), put(" ledger");
  put_bits(ledger.stored);
  put_bits(ledger.port_work);
  put_bits(ledger.virtual_force_work);
  put_bits(ledger.outside_work);
  put_bits(ledger.original_leak);
  put_bits(ledger.held_leak);
  end_line();
}

static int replay(const char *name, const palpate_contact_params *params) {
  palpate_loop_params loop = palpate_loop_params_default();
  palpate_contact_f32 *contact;
  loop.period = 0.001;
  loop.device_mass = 0.1;
  loop.speed_limit = 3.0;
  loop.force_limit = 5.0;
  loop.slew_limit = 3000.0;
  loop.guard = PALPATE_GUARD_LIMIT;
  loop.guard_speed = 1.0;
  loop.guard_allowance = 1e-3;
  if (palpate_contact_f32_place(memory, sizeof memory, params, &loop, &contact) != PALPATE_STATUS_OK) {
    say(palpate_last_error());
    say("\n");
    return 1;
  }
  for (uint32_t tick = 0; tick < SAMPLE_COUNT; tick++) {
    palpate_sample_f32 sample = palpate_sample_f32_at(of_bits(samples[tick].device_position));
    palpate_output_f32 output = palpate_output_f32_empty();
    sample.elapsed = of_bits(samples[tick].elapsed);
    sample.has_elapsed = samples[tick].has_elapsed;
    sample.virtual_force = of_bits(samples[tick].virtual_force);
    const uint32_t before = reading();
    palpate_contact_f32_step(contact, &sample, &output);
    const uint32_t instructions = instructions_between(before, reading());
    if (COUNTING) {
      show_count(name, tick, &output, instructions);
    } else {
      show_tick(name, tick, &output);
    }
  }
  if (!COUNTING) show_ledger(name, contact);
  return 0;
}

int main(void) {
  const palpate_setting damping = {"damping_n_s_per_m", 0.02, NULL};
  palpate_contact_params block = palpate_contact_params_default();
  palpate_contact_params wall = palpate_contact_params_default();
  int failures = 0;
  start_counting();
  block.stiffness = 1000.0;
  block.object_mass = 0.1;
  block.object_position = 0.01;
  block.unilateral = 1;
  wall.stiffness = 3000.0;
  wall.object_position = -0.002;
  block.method = wall.method = "hfcr";
  block.settings = wall.settings = &damping;
  block.setting_count = wall.setting_count = 1;
  failures += replay("hfcr-block", &block);
  failures += replay("hfcr-wall", &wall);
  block.method = wall.method = "coupled";
  block.setting_count = wall.setting_count = 0;
  failures += replay("coupled-block", &block);
  failures += replay("coupled-wall", &wall);
  return failures;
}
