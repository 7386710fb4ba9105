#include "runtime/app/service_manager.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include <sys/socket.h>
#include <sys/un.h>

namespace cloister {
namespace {

/// What an environment variable holds, 0 when it is no number.
long long number_in(const char* variable) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::strtoll(text, nullptr, 10) : 0;
}

}  // namespace

ServiceManager::ServiceManager() {
  const char* address = std::getenv("NOTIFY_SOCKET");
  if (address == nullptr || (address[0] != '/' && address[0] != '@')) return;
  address_ = address;
  if (address_.size() >= sizeof(sockaddr_un::sun_path)) return;
  fd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  // Set but of another process: it is that one's watchdog.
  const long long watched = number_in("WATCHDOG_PID");
  if (watched == 0 || watched == getpid())
    period_ = std::chrono::microseconds(std::max(0LL, number_in("WATCHDOG_USEC")) / 2);
}

ServiceManager::~ServiceManager() {
  if (fd_ >= 0) close(fd_);
}

void ServiceManager::ready() { send("READY=1"); }

void ServiceManager::stopping() { send("STOPPING=1"); }

void ServiceManager::alive() {
  if (period_.count() == 0) return;
  const Clock::time_point now = Clock::now();
  if (now - last_alive_ < period_) return;
  last_alive_ = now;
  send("WATCHDOG=1");
}

void ServiceManager::send(std::string_view message) const {
  if (fd_ < 0) return;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::copy(address_.begin(), address_.end(), to.sun_path);
  if (to.sun_path[0] == '@') to.sun_path[0] = '\0';
  const auto length = offsetof(sockaddr_un, sun_path) + address_.size();
  // Lost is lost: the manager acts on what it does not hear.
  (void)sendto(fd_, message.data(), message.size(), MSG_NOSIGNAL,
               reinterpret_cast<const sockaddr*>(&to), static_cast<socklen_t>(length));
}

}  // namespace cloister
