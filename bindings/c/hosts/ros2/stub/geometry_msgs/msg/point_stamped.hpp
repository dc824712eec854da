// Subset of the messages that wall.cpp needs.
#pragma once
#include <cstdint>

namespace std_msgs::msg {
struct Header {
  struct {
    std::int32_t sec = 0;
    std::uint32_t nanosec = 0;
  } stamp;
};
}  // namespace std_msgs::msg

namespace geometry_msgs::msg {
struct PointStamped {
  std_msgs::msg::Header header;
  struct {
    double x = 0.0, y = 0.0, z = 0.0;
  } point;
};
}  // namespace geometry_msgs::msg
