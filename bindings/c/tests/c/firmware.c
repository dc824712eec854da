/* The firmware library: a contact in static memory, no heap. Wall and motion are those of examples/loop.c. */
#include <palpate.h>
#include <stdio.h>
#include <stdlib.h>

/* A real firmware sets the motor forces to zero here and resets. */
void palpate_panicked(void) { abort(); }

static _Alignas(PALPATE_CONTACT_ALIGN_MAX) unsigned char memory[PALPATE_CONTACT_SIZE_MAX];

int main(void) {
  palpate_loop_params loop = palpate_loop_params_default();
  palpate_contact_params params = palpate_contact_params_default();
  palpate_contact *contact;
  int tick;
  loop.device_mass = 0.25;
  params.stiffness = 1000.0;
  if (palpate_contact_place(memory, sizeof memory, &params, &loop, &contact) == PALPATE_STATUS_OK) {
    return 1; /* the period is missing */
  }
  fprintf(stderr, "%s\n", palpate_last_error());
  loop.period = 0.001;
  if (palpate_contact_place(memory, sizeof memory, &params, &loop, &contact) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  for (tick = 0; tick < 20; tick++) {
    double position = tick < 10 ? 1e-4 * tick : 1e-4 * (19 - tick);
    palpate_sample sample = palpate_sample_at(position);
    printf("%g %.17g\n", position, palpate_contact_step(contact, &sample, NULL));
  }
  return 0;
}
