// A floor rendered by palpate as a ROS 2 node: it receives positions as stamped points and publishes forces as
// wrenches. z = 0 is the surface.
//
// License: MIT OR Apache-2.0
#include <cstdio>
#include <geometry_msgs/msg/point_stamped.hpp>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <memory>
#include <palpate.hpp>
#include <rclcpp/rclcpp.hpp>

using geometry_msgs::msg::PointStamped;
using geometry_msgs::msg::WrenchStamped;

class Floor : public rclcpp::Node {
 public:
  Floor() : Node("palpate_floor"), floor_(contact()) {
    wrenches_ = create_publisher<WrenchStamped>("wrench", 1);
    points_ = create_subscription<PointStamped>("position", 1, [this](const PointStamped &point) { tick(point); });
  }

 private:
  static palpate::Contact contact() {
    auto loop = palpate::loop_params(0.001);  // [s]
    loop.device_mass = 0.1;                   // [kg]
    loop.force_limit = 5.0;                   // [N]
    auto params = palpate::contact_params(1000.0);  // [N/m]
    params.side = PALPATE_SIDE_NEGATIVE;
    return palpate::Contact(params, loop);
  }

  void tick(const PointStamped &point) {
    const double now = point.header.stamp.sec + 1e-9 * point.header.stamp.nanosec;  // [s]
    palpate_sample sample = palpate_sample_at(point.point.z);
    sample.elapsed = now - last_;
    sample.has_elapsed = has_last_;
    last_ = now;
    has_last_ = true;
    WrenchStamped wrench;
    wrench.header = point.header;
    wrench.wrench.force.z = floor_.step(sample);
    wrenches_->publish(wrench);
  }

  palpate::Contact floor_;
  double last_ = 0.0;
  bool has_last_ = false;
  rclcpp::Publisher<WrenchStamped>::SharedPtr wrenches_;
  rclcpp::Subscription<PointStamped>::SharedPtr points_;
};

int main(int argc, char **argv) {
  rclcpp::init(argc, argv);
  try {
    rclcpp::spin(std::make_shared<Floor>());
  } catch (const palpate::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  rclcpp::shutdown();
}
