#include "firmware_interface/ouster/sensor_http.hpp"

#include <netdb.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include <sys/socket.h>

#include "firmware_interface/ouster/http_response.hpp"

namespace cloister {
namespace {

constexpr const char* kPath = "/api/v1/sensor/metadata";
// A sensor's metadata takes some 10 kB.
constexpr std::size_t kMaxResponseBytes = 1 << 20;

using Clock = std::chrono::steady_clock;

class Socket {
 public:
  explicit Socket(int fd) : fd_(fd) {}
  ~Socket() {
    if (fd_ >= 0) close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  [[nodiscard]] int fd() const { return fd_; }

  /// Waits until the socket is ready, or until the deadline.
  [[nodiscard]] bool wait(short events, Clock::time_point deadline) const {
    while (true) {
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
      if (left <= 0) return false;
      pollfd waited{fd_, events, 0};
      const int ready = poll(&waited, 1, static_cast<int>(left));
      if (ready > 0) return true;
      if (ready < 0 && errno != EINTR) return false;
    }
  }

 private:
  int fd_;
};

/// Returns what went wrong, or an empty string when it is connected.
std::string connect_until(const Socket& socket, const addrinfo& address,
                          Clock::time_point deadline) {
  if (connect(socket.fd(), address.ai_addr, address.ai_addrlen) == 0) return {};
  if (errno != EINPROGRESS) return std::strerror(errno);
  if (!socket.wait(POLLOUT, deadline)) return "no answer in time";
  int error = 0;
  socklen_t size = sizeof(error);
  (void)getsockopt(socket.fd(), SOL_SOCKET, SO_ERROR, &error, &size);
  return error == 0 ? std::string() : std::strerror(error);
}

std::string exchange(const Socket& socket, const std::string& request, Clock::time_point deadline,
                     HttpResponse& response) {
  for (std::size_t sent = 0; sent < request.size();) {
    if (!socket.wait(POLLOUT, deadline)) return "no answer in time";
    const ssize_t count =
        send(socket.fd(), request.data() + sent, request.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno != EAGAIN && errno != EINTR) return std::strerror(errno);
    sent += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  std::string received;
  std::array<char, 16384> part;
  while (true) {
    if (!socket.wait(POLLIN, deadline)) return "no answer in time";
    const ssize_t count = recv(socket.fd(), part.data(), part.size(), 0);
    if (count < 0) {
      if (errno == EAGAIN || errno == EINTR) continue;
      return std::strerror(errno);
    }
    received.append(part.data(), static_cast<std::size_t>(count));
    switch (read_http_response(received, count == 0, response)) {
      case HttpProgress::kComplete:
        return {};
      case HttpProgress::kMalformed:
        return "the answer is no HTTP";
      case HttpProgress::kIncomplete:
        break;
    }
    if (received.size() > kMaxResponseBytes) return "the answer does not end";
  }
}

}  // namespace

Result<std::string> fetch_sensor_metadata(const std::string& host,
                                          std::chrono::milliseconds timeout) {
  const std::string url = "http://" + host + kPath;
  const auto failed = [&](const std::string& why) {
    return fail(ErrorKind::kResource,
                url + ": " + why + "; is the sensor switched on and in this network?");
  };
  const Clock::time_point deadline = Clock::now() + timeout;
  // A colon alone begins a port; several are an IPv6 address.
  const std::size_t colon = host.find(':');
  const bool has_port =
      colon != std::string::npos && host.find(':', colon + 1) == std::string::npos;
  const std::string name = has_port ? host.substr(0, colon) : host;
  const std::string port = has_port ? host.substr(colon + 1) : "80";

  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(name.c_str(), port.c_str(), &wanted, &found); error != 0) {
    return failed(gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, &freeaddrinfo);
  std::string why = "no address";
  for (const addrinfo* address = addresses.get(); address != nullptr; address = address->ai_next) {
    const Socket socket(
        ::socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (socket.fd() < 0) continue;
    why = connect_until(socket, *address, deadline);
    if (!why.empty()) continue;
    HttpResponse response;
    why = exchange(socket,
                   std::string("GET ") + kPath + " HTTP/1.1\r\nHost: " + host +
                       "\r\nAccept: application/json\r\nConnection: close\r\n\r\n",
                   deadline, response);
    if (!why.empty()) continue;
    if (response.status != 200)
      return failed("answers with status " + std::to_string(response.status));
    return std::move(response.body);
  }
  return failed(why);
}

}  // namespace cloister
