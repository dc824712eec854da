// A contact in a loop in C++, with the wall and motion of loop.c.
#include <cstdio>
#include <palpate.hpp>

int main() try {
  auto loop = palpate::loop_params(0.001);  // [s]
  loop.device_mass = 0.25;                  // about its effective mass [kg]
  palpate::Contact contact(palpate::contact_params(1000.0), loop);  // [N/m]
  for (int tick = 0; tick < 20; tick++) {
    double position = tick < 10 ? 1e-4 * tick : 1e-4 * (19 - tick);  // read your device here [m]
    double force = contact.step(position);                           // command this [N]
    std::printf("%g %.17g\n", position, force);
  }
} catch (const palpate::Error &error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
