// A wall rendered by palpate in the servo loop of OpenHaptics (HDAPI): y = 0 is the surface, a floor below the device.
//
// License: MIT OR Apache-2.0
#include <HD/hd.h>

#include <cstdio>
#include <palpate.hpp>

namespace {

// One tick, called by the servo thread.
HDCallbackCode HDCALLBACK tick(void *data) {
  auto &floor = *static_cast<palpate::Contact *>(data);
  HDdouble position[3];  // [mm]
  hdBeginFrame(hdGetCurrentDevice());
  hdGetDoublev(HD_CURRENT_POSITION, position);
  // The floor is on the negative side; see `params.side` below.
  const HDdouble force[3] = {0.0, floor.step(0.001 * position[1]), 0.0};  // [N]
  hdSetDoublev(HD_CURRENT_FORCE, force);
  hdEndFrame(hdGetCurrentDevice());
  return HD_CALLBACK_CONTINUE;
}

}  // namespace

int main() try {
  HHD device = hdInitDevice(HD_DEFAULT_DEVICE);
  if (device == HD_INVALID_HANDLE) {
    std::fprintf(stderr, "no device\n");
    return 1;
  }
  auto loop = palpate::loop_params(0.001);  // [s], the servo loop's
  loop.device_mass = 0.05;                  // about that of the end-point [kg]
  loop.force_limit = 3.0;                   // limit of the device [N]
  auto params = palpate::contact_params(500.0);  // [N/m]
  params.side = PALPATE_SIDE_NEGATIVE;
  palpate::Contact floor(params, loop);

  hdEnable(HD_FORCE_OUTPUT);
  HDSchedulerHandle handle = hdScheduleAsynchronous(tick, &floor, HD_MAX_SCHEDULER_PRIORITY);
  hdStartScheduler();
  std::puts("press return to end");
  std::getchar();
  hdStopScheduler();
  hdUnschedule(handle);
  hdDisableDevice(device);
} catch (const palpate::Error &error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
