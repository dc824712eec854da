// A device of 50 g that falls onto the floor from 10 mm, pressed with 0.5 N and damped with 1 N s/m. The scheduler
// simulates two seconds.
#include <HD/hd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

static HDSchedulerCallback callback;
static void *data;
static double height = 0.010, velocity = 0.0, force = 0.0;  // [m], [m/s], [N]

HHD hdInitDevice(const char *) { return 0; }
HHD hdGetCurrentDevice() { return 0; }
void hdDisableDevice(HHD) {}
void hdBeginFrame(HHD) {}
void hdEndFrame(HHD) {}
void hdEnable(HDenum) {}
void hdUnschedule(HDSchedulerHandle) {}
void hdStopScheduler() {}

void hdGetDoublev(HDenum, HDdouble *values) {
  values[0] = values[2] = 0.0;
  values[1] = 1000.0 * height;
}

void hdSetDoublev(HDenum, const HDdouble *values) { force = values[1]; }

HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback scheduled, void *with, unsigned) {
  callback = scheduled;
  data = with;
  return 1;
}

void hdStartScheduler() {
  for (int tick = 0; tick < 2000; tick++) {
    callback(data);
    velocity += (force - 0.5 - 1.0 * velocity) / 0.05 * 0.001;
    height += velocity * 0.001;
  }
  std::printf("openhaptics: the device rests %.6f m in the floor, held by %.3f N\n", -height, force);
  // The device presses with 0.5 N on a floor of 500 N/m, which compresses by 1 mm.
  if (!(std::fabs(force - 0.5) < 0.005 && height < -0.0005 && height > -0.0015)) {
    std::fprintf(stderr, "the floor does not hold the device\n");
    std::exit(1);
  }
}
