// Drives the generated node: each line of standard input is what happens in one period, and each line of standard
// output what was published in it.
//   hear fx fy fz rx ry rz   a request comes, then the timer fires
//   unmeasured fx fy fz      the same, and the message says that rates were not measured
//   tick                     the timer fires without one
//   wait                     longer than the timeout passes, then the timer fires
//   stop                     the node is asked to end, then the timer fires
#define main node_main
#include "node.cpp"
#undef main
#include <iostream>
#include <sstream>
#include <thread>

int main(int argc, char ** argv)
{
  const double timeout = argc > 1 ? std::stod(argv[1]) : 0.05;
  rclcpp::given()["timeout"] = timeout;
  if (argc > 2) rclcpp::given()["leg_zero"] = std::vector<double>(std::stoi(argv[2]), 0.25);
  std::unique_ptr<Cueing> node;
  try {
    node = std::make_unique<Cueing>();
  } catch (const std::invalid_argument & refused) {
    std::cerr << refused.what() << "\n";
    return 2;
  }
  std::cout.precision(17);
  std::cout << rclcpp::timer_period().count() << "\n";
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string what;
    words >> what;
    if (what == "hear" || what == "unmeasured") {
      Imu request;
      std::string number[6] = {"0", "0", "0", "0", "0", "0"};
      for (auto & one : number) words >> one;
      request.linear_acceleration = {std::stod(number[0]), std::stod(number[1]), std::stod(number[2])};
      request.angular_velocity = {std::stod(number[3]), std::stod(number[4]), std::stod(number[5])};
      if (what == "unmeasured") {
        request.angular_velocity = {7.0, 7.0, 7.0};
        request.angular_velocity_covariance[0] = -1.0;
      }
      rclcpp::hear("wanted", request);
    } else if (what == "wait") {
      std::this_thread::sleep_for(std::chrono::duration<double>(1.2 * timeout));
    } else if (what == "stop") {
      node->stop();
    }
    rclcpp::timer()();
    const auto pose = std::any_cast<PoseStamped>(rclcpp::published()["pose"]).pose;
    const auto twist = std::any_cast<TwistStamped>(rclcpp::published()["velocity"]).twist;
    const auto accel = std::any_cast<AccelStamped>(rclcpp::published()["acceleration"]).accel;
    const int status = std::any_cast<UInt8>(rclcpp::published()["status"]).data;
    std::cout << status << " " << node->at_rest();
    for (double v : {pose.position.x, pose.position.y, pose.position.z, pose.orientation.x, pose.orientation.y,
        pose.orientation.z, pose.orientation.w, twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.x,
        twist.angular.y, twist.angular.z, accel.linear.x, accel.linear.y, accel.linear.z}) std::cout << " " << v;
    if (rclcpp::published().count("legs"))
      for (double v : std::any_cast<Float64MultiArray>(rclcpp::published()["legs"]).data) std::cout << " " << v;
    std::cout << std::endl;
  }
}
