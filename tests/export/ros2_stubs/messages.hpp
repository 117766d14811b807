// The messages that the generated node uses, with the fields that it uses.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace rclcpp { struct Time; }
namespace stub
{
struct Stamp { template <typename T> Stamp & operator=(const T &) { return *this; } };
struct Header { Stamp stamp; std::string frame_id; };
}  // namespace stub
namespace geometry_msgs::msg
{
struct Vector3 { double x = 0, y = 0, z = 0; };
struct Point { double x = 0, y = 0, z = 0; };
struct Quaternion { double x = 0, y = 0, z = 0, w = 1; };
struct Pose { Point position; Quaternion orientation; };
struct Twist { Vector3 linear, angular; };
struct Accel { Vector3 linear, angular; };
struct PoseStamped { stub::Header header; Pose pose; };
struct TwistStamped { stub::Header header; Twist twist; };
struct AccelStamped { stub::Header header; Accel accel; };
}  // namespace geometry_msgs::msg
namespace sensor_msgs::msg
{
struct Imu
{
  geometry_msgs::msg::Vector3 linear_acceleration, angular_velocity;
  std::array<double, 9> linear_acceleration_covariance{}, angular_velocity_covariance{};
};
}  // namespace sensor_msgs::msg
namespace std_msgs::msg
{
struct Float64MultiArray { std::vector<double> data; };
struct UInt8 { uint8_t data = 0; };
}  // namespace std_msgs::msg
