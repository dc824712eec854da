// Subset of rclcpp that wall.cpp needs, for CI without ROS 2. `spin` simulates a device of 100 g, pressed onto the
// floor with 0.5 N and damped with 1 N s/m, for two seconds.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "geometry_msgs/msg/point_stamped.hpp"
#include "geometry_msgs/msg/wrench_stamped.hpp"

namespace rclcpp {

template <typename Message>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher>;
  Message last;
  void publish(const Message &message) { last = message; }
};

template <typename Message>
struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
  std::function<void(const Message &)> take;
};

class Node {
 public:
  explicit Node(const std::string &) {}
  virtual ~Node() = default;

  template <typename Message>
  std::shared_ptr<Publisher<Message>> create_publisher(const std::string &, int) {
    wrenches = std::make_shared<Publisher<Message>>();
    return wrenches;
  }

  template <typename Message, typename Callback>
  std::shared_ptr<Subscription<Message>> create_subscription(const std::string &, int, Callback callback) {
    points = std::make_shared<Subscription<Message>>();
    points->take = callback;
    return points;
  }

  std::shared_ptr<Publisher<geometry_msgs::msg::WrenchStamped>> wrenches;
  std::shared_ptr<Subscription<geometry_msgs::msg::PointStamped>> points;
};

inline void init(int, char **) {}
inline void shutdown() {}

inline void spin(const std::shared_ptr<Node> &node) {
  double height = 0.01, velocity = 0.0, force = 0.0;
  for (int tick = 0; tick < 2000; tick++) {
    geometry_msgs::msg::PointStamped point;
    point.header.stamp.sec = tick / 1000;
    point.header.stamp.nanosec = static_cast<std::uint32_t>(tick % 1000) * 1000000u;
    point.point.z = height;
    node->points->take(point);
    force = node->wrenches->last.wrench.force.z;
    velocity += (force - 0.5 - 1.0 * velocity) / 0.1 * 0.001;
    height += velocity * 0.001;
  }
  std::printf("ros2: the device rests %.6f m in the floor, held by %.3f N\n", -height, force);
  if (!(std::fabs(force - 0.5) < 0.005 && height < -0.0002 && height > -0.0008)) {
    std::fprintf(stderr, "the floor does not hold the device\n");
    std::exit(1);
  }
}

}  // namespace rclcpp
