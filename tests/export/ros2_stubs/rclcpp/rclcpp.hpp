// As much of rclcpp as the generated node uses, without a network: what is published stands in `published()`, what
// is heard is handed over by `hear`, and a timer fires when a test says so. For tests where there is no ROS.
#pragma once
#include <any>
#include <chrono>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#define RCLCPP_SAY(logger, ...) (std::fprintf(stderr, "[%s] ", (logger).name.c_str()), \
  std::fprintf(stderr, __VA_ARGS__), std::fprintf(stderr, "\n"))
#define RCLCPP_INFO(logger, ...) RCLCPP_SAY(logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) RCLCPP_SAY(logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) RCLCPP_SAY(logger, __VA_ARGS__)

namespace rclcpp
{
struct Time { double seconds = 0.0; };
struct Logger { std::string name; };
struct QoS { QoS(int depth) { (void)depth; } };
struct SensorDataQoS {};
struct InitOptions {};
enum class SignalHandlerOptions { None };
inline void init(int, char **, const InitOptions &, SignalHandlerOptions) {}
inline void shutdown() {}
inline bool ok() { return true; }
inline Logger get_logger(const std::string & name) { return {name}; }

inline std::map<std::string, std::any> & published() { static std::map<std::string, std::any> all; return all; }
inline std::map<std::string, std::any> & given() { static std::map<std::string, std::any> all; return all; }
inline std::map<std::string, std::any> & listeners() { static std::map<std::string, std::any> all; return all; }
inline std::function<void()> & timer() { static std::function<void()> one; return one; }
inline std::chrono::nanoseconds & timer_period() { static std::chrono::nanoseconds one; return one; }

template <typename Message>
struct Publisher
{
  using SharedPtr = std::shared_ptr<Publisher>;
  std::string topic;
  void publish(const Message & message) { published()[topic] = message; }
};
template <typename Message>
struct Subscription { using SharedPtr = std::shared_ptr<Subscription>; };
struct TimerBase { using SharedPtr = std::shared_ptr<TimerBase>; };

template <typename Message>
void hear(const std::string & topic, const Message & message)
{
  std::any_cast<std::function<void(const Message &)>>(listeners().at(topic))(message);
}

class Node
{
public:
  explicit Node(const std::string & name) : name_(name) {}
  template <typename T>
  T declare_parameter(const std::string & name, const T & otherwise)
  {
    return given().count(name) ? std::any_cast<T>(given().at(name)) : otherwise;
  }
  template <typename Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string & topic, const QoS &)
  {
    return std::make_shared<Publisher<Message>>(Publisher<Message>{topic});
  }
  template <typename Message, typename Callback>
  typename Subscription<Message>::SharedPtr create_subscription(
    const std::string & topic, const SensorDataQoS &, Callback && callback)
  {
    listeners()[topic] = std::function<void(const Message &)>(callback);
    return std::make_shared<Subscription<Message>>();
  }
  template <typename Callback>
  TimerBase::SharedPtr create_wall_timer(std::chrono::nanoseconds period, Callback && callback)
  {
    timer_period() = period;
    timer() = callback;
    return std::make_shared<TimerBase>();
  }
  Logger get_logger() const { return {name_}; }
  Time now() const { return {}; }

private:
  std::string name_;
};

namespace executors
{
struct SingleThreadedExecutor
{
  void add_node(const std::shared_ptr<Node> &) {}
  void spin_once(std::chrono::nanoseconds) { timer()(); }
};
}  // namespace executors
}  // namespace rclcpp
