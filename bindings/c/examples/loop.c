/* A contact in a loop: a device is pushed 1 mm into a wall at 0 m and pulled back. */
#include <palpate.h>
#include <stdio.h>

int main(void) {
  palpate_loop_params loop = palpate_loop_params_default();
  palpate_contact_params params = palpate_contact_params_default();
  palpate_contact *contact;
  loop.period = 0.001;      /* [s] */
  loop.device_mass = 0.25;  /* about its effective mass [kg] */
  params.stiffness = 1000.0; /* [N/m] */
  if (palpate_contact_new(&params, &loop, &contact) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  for (int tick = 0; tick < 20; tick++) {
    double position = tick < 10 ? 1e-4 * tick : 1e-4 * (19 - tick); /* read your device here [m] */
    palpate_sample sample = palpate_sample_at(position);
    double force = palpate_contact_step(contact, &sample, NULL); /* command this [N] */
    printf("%g %.17g\n", position, force);
  }
  palpate_contact_free(contact);
  return 0;
}
