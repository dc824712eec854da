/* The ticks that bindings/c/measure times: METHOD COUNT. A 16 mm sine about the surface of an object of 0.1 kg, at
   1 kHz. examples/ticks.rs runs the same in Rust. */
#include <palpate.h>
#include <stdio.h>
#include <stdlib.h>

enum { POSITION_COUNT = 500 };

int main(int argc, char **argv) {
  palpate_loop_params loop = palpate_loop_params_default();
  palpate_contact_params params = palpate_contact_params_default();
  palpate_contact *contact;
  double positions[POSITION_COUNT], position = 0.0, velocity = 0.001, sum = 0.0;
  long count = argc > 2 ? atol(argv[2]) : 0;
  if (argc != 3) {
    fprintf(stderr, "usage: ticks METHOD COUNT\n");
    return 1;
  }
  loop.period = 0.001;
  loop.device_mass = 0.25;
  params.method = argv[1];
  params.stiffness = 1000.0;
  params.object_mass = 0.1;
  params.virtual_force = -0.981;
  if (palpate_contact_new(&params, &loop, &contact) != PALPATE_STATUS_OK) {
    fprintf(stderr, "%s\n", palpate_last_error());
    return 1;
  }
  /* x'' = -(0.2 x): five oscillations in the table. */
  for (int at = 0; at < POSITION_COUNT; at++) {
    positions[at] = position;
    velocity -= 0.004 * position;
    position += velocity;
    if (at % 100 == 99) {
      position = 0.0;
      velocity = 0.001;
    }
  }
  for (long tick = 0; tick < count; tick++) {
    palpate_sample sample = palpate_sample_at(positions[tick % POSITION_COUNT]);
    palpate_output output = palpate_output_empty();
    sum += palpate_contact_step(contact, &sample, &output) + output.penetration;
  }
  printf("%.17g\n", sum);
  palpate_contact_free(contact);
  return 0;
}
