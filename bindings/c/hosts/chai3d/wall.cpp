// A floor rendered by palpate on a CHAI3D device, in the haptic thread: z = 0 is the surface. The first switch of the
// device ends the program.
//
// License: MIT OR Apache-2.0
#include <chai3d.h>

#include <cstdio>
#include <palpate.hpp>

using namespace chai3d;

int main() try {
  cHapticDeviceHandler handler;
  cGenericHapticDevicePtr device;
  if (!handler.getDevice(device, 0) || !device->open()) {
    std::fprintf(stderr, "no device\n");
    return 1;
  }
  device->calibrate();

  auto loop = palpate::loop_params(0.001);  // about the period of this thread [s]
  loop.device_mass = 0.1;                   // about that of the end-point [kg]
  loop.force_limit = device->getSpecifications().m_maxLinearForce;  // [N]
  auto params = palpate::contact_params(1000.0);                    // [N/m]
  params.side = PALPATE_SIDE_NEGATIVE;                              // the floor is below the device
  palpate::Contact floor(params, loop);

  cPrecisionClock clock;
  bool ended = false;
  for (bool is_first = true; !ended; is_first = false) {
    cVector3d position;  // [m]
    device->getPosition(position);
    palpate_sample sample = palpate_sample_at(position.z());
    sample.elapsed = clock.getCurrentTimeSeconds();  // since the previous sample [s]
    sample.has_elapsed = !is_first;
    clock.start(true);
    device->setForce(cVector3d(0.0, 0.0, floor.step(sample)));  // [N]
    device->getUserSwitch(0, ended);
  }
  device->setForce(cVector3d(0.0, 0.0, 0.0));
  device->close();
} catch (const palpate::Error &error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
