// Subset of HDAPI that wall.cpp needs, for CI without OpenHaptics.
#pragma once

using HDdouble = double;
using HHD = unsigned;
using HDenum = unsigned;
using HDCallbackCode = unsigned;
using HDSchedulerHandle = unsigned long;
#define HDCALLBACK
using HDSchedulerCallback = HDCallbackCode(HDCALLBACK *)(void *);

enum : unsigned {
  HD_INVALID_HANDLE = 0xffffffff,
  HD_CALLBACK_CONTINUE = 1,
  HD_CURRENT_POSITION,
  HD_CURRENT_FORCE,
  HD_FORCE_OUTPUT,
  HD_MAX_SCHEDULER_PRIORITY,
};
constexpr const char *HD_DEFAULT_DEVICE = nullptr;

HHD hdInitDevice(const char *name);
void hdDisableDevice(HHD device);
HHD hdGetCurrentDevice();
void hdBeginFrame(HHD device);
void hdEndFrame(HHD device);
void hdGetDoublev(HDenum what, HDdouble *values);
void hdSetDoublev(HDenum what, const HDdouble *values);
void hdEnable(HDenum what);
HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void *data, unsigned priority);
void hdUnschedule(HDSchedulerHandle handle);
void hdStartScheduler();
void hdStopScheduler();
