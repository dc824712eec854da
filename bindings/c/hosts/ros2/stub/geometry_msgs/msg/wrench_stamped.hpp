// Subset of the messages that wall.cpp needs.
#pragma once
#include "point_stamped.hpp"

namespace geometry_msgs::msg {
struct WrenchStamped {
  std_msgs::msg::Header header;
  struct {
    struct {
      double x = 0.0, y = 0.0, z = 0.0;
    } force;
  } wrench;
};
}  // namespace geometry_msgs::msg
