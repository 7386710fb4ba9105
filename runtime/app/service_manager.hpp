#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace cloister {

/// Tells systemd, or what stands in for it, how this process is: one datagram a message to the socket that the variable
/// NOTIFY_SOCKET names, as sd_notify(3) defines them. Where nobody asked for it, or the message cannot be sent, nothing
/// happens.
///
/// Threads: one. Nothing here waits.
class ServiceManager {
 public:
  /// As the environment says: NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  void ready();
  void stopping();
  /// To be called often while all is well. Sent twice in the time after which the watchdog bites.
  void alive();

 private:
  using Clock = std::chrono::steady_clock;

  void send(std::string_view message) const;

  int fd_ = -1;
  std::string
      address_;  ///< of the socket: a path, or a name in the abstract space that begins with '@'
  std::chrono::microseconds period_{0};  ///< between two signs of life; 0: nobody waits for them
  Clock::time_point last_alive_;
};

}  // namespace cloister
