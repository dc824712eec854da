// Subset of CHAI3D that wall.cpp needs, for CI. Its device weighs 100 g, is pressed onto the floor with 0.5 N and
// damped with 1 N s/m; it ends after two seconds of simulated time.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

namespace chai3d {

class cVector3d {
 public:
  cVector3d() = default;
  cVector3d(double x, double y, double z) : x_(x), y_(y), z_(z) {}
  double x() const { return x_; }
  double y() const { return y_; }
  double z() const { return z_; }

 private:
  double x_ = 0.0, y_ = 0.0, z_ = 0.0;
};

struct cHapticDeviceInfo {
  double m_maxLinearForce = 8.0;
};

class cGenericHapticDevice {
 public:
  bool open() { return true; }
  bool calibrate(bool = false) { return true; }
  cHapticDeviceInfo getSpecifications() { return {}; }

  bool getPosition(cVector3d &position) {
    position = cVector3d(0.0, 0.0, height_);
    return true;
  }

  bool setForce(const cVector3d &force) {
    if (!ended_) {
      velocity_ += (force.z() - 0.5 - 1.0 * velocity_) / 0.1 * 0.001;
      height_ += velocity_ * 0.001;
      ended_ = ++ticks_ == 2000;
      last_held_ = force.z();
    }
    force_ = force.z();
    return true;
  }

  bool getUserSwitch(int, bool &pressed) {
    pressed = ended_;
    return true;
  }

  bool close() {
    std::printf("chai3d: the device rests %.6f m in the floor, held by %.3f N\n", -height_, last_held_);
    // 0.5 N compress 1000 N/m by 0.5 mm.
    if (!(std::fabs(last_held_ - 0.5) < 0.005 && height_ < -0.0002 && height_ > -0.0008 && force_ == 0.0)) {
      std::fprintf(stderr, "the floor does not hold the device, or the force stays at the end\n");
      std::exit(1);
    }
    return true;
  }

 private:
  double height_ = 0.01, velocity_ = 0.0, force_ = 0.0, last_held_ = 0.0;
  int ticks_ = 0;
  bool ended_ = false;
};

using cGenericHapticDevicePtr = std::shared_ptr<cGenericHapticDevice>;

class cHapticDeviceHandler {
 public:
  bool getDevice(cGenericHapticDevicePtr &device, unsigned) {
    device = std::make_shared<cGenericHapticDevice>();
    return true;
  }
};

// Every tick comes one period after the previous one: simulated time, not wall-clock time.
class cPrecisionClock {
 public:
  double start(bool = false) { return 0.0; }
  double getCurrentTimeSeconds() const { return 0.001; }
};

}  // namespace chai3d
