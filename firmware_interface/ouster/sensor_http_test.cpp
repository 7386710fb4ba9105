#include "firmware_interface/ouster/sensor_http.hpp"

#include <unistd.h>

#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "firmware_interface/ouster/http_response.hpp"

namespace cloister {
namespace {

using namespace std::chrono_literals;

/// Stands in for a sensor: answers one connection with the given parts, or, without any, stays silent.
class StandIn {
 public:
  explicit StandIn(std::vector<std::string> parts) : parts_(std::move(parts)) {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    REQUIRE(bind(listener_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    REQUIRE(listen(listener_, 1) == 0);
    REQUIRE(getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    host_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    if (!parts_.empty()) thread_ = std::thread([this] { answer(); });
  }
  ~StandIn() {
    if (thread_.joinable()) thread_.join();
    close(listener_);
  }
  [[nodiscard]] const std::string& host() const { return host_; }
  /// What was asked. After the answer.
  [[nodiscard]] std::string request() {
    thread_.join();
    return request_;
  }

 private:
  void answer() {
    const int connection = accept(listener_, nullptr, nullptr);
    char buffer[4096];
    while (request_.find("\r\n\r\n") == std::string::npos) {
      const ssize_t count = recv(connection, buffer, sizeof(buffer), 0);
      if (count <= 0) break;
      request_.append(buffer, static_cast<std::size_t>(count));
    }
    for (const std::string& part : parts_)
      (void)send(connection, part.data(), part.size(), MSG_NOSIGNAL);
    close(connection);
  }

  std::vector<std::string> parts_;
  std::string host_;
  std::string request_;
  int listener_ = -1;
  std::thread thread_;
};

TEST_CASE("a sensor's metadata is fetched whole, however the answer is cut") {
  const std::string json(50'000, 'x');
  StandIn sensor({"HTTP/1.1 200 OK\r\nContent-", "Length: 50000\r\n\r\n", json.substr(0, 10),
                  json.substr(10)});
  const auto body = fetch_sensor_metadata(sensor.host(), 5s);
  REQUIRE(body.has_value());
  CHECK(*body == json);
  const std::string request = sensor.request();
  CHECK(request.starts_with("GET /api/v1/sensor/metadata HTTP/1.1\r\n"));
  CHECK(request.find("Host: " + sensor.host() + "\r\n") != std::string::npos);
}

TEST_CASE("a sensor that refuses, is silent or is not there is an error that names it") {
  SUBCASE("it answers with an error") {
    StandIn sensor({"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n"});
    const auto body = fetch_sensor_metadata(sensor.host(), 5s);
    REQUIRE_FALSE(body.has_value());
    CHECK(body.error().message.find("503") != std::string::npos);
    CHECK(body.error().message.find(sensor.host()) != std::string::npos);
  }
  SUBCASE("it is silent") {
    StandIn sensor({});
    const auto body = fetch_sensor_metadata(sensor.host(), 100ms);
    REQUIRE_FALSE(body.has_value());
    CHECK(body.error().message.find("in time") != std::string::npos);
  }
  SUBCASE("it is not there") {
    std::string host;
    {
      StandIn sensor({});
      host = sensor.host();
    }
    const auto body = fetch_sensor_metadata(host, 5s);
    REQUIRE_FALSE(body.has_value());
    CHECK(body.error().kind == ErrorKind::kResource);
  }
  SUBCASE("it hangs up in the middle") {
    StandIn sensor({"HTTP/1.1 200 OK\r\nContent-Length: 100\r\n\r\nabc"});
    CHECK_FALSE(fetch_sensor_metadata(sensor.host(), 5s).has_value());
  }
}

TEST_CASE("a response's body ends where its head says") {
  const auto read = [](std::string_view bytes, bool is_ended, HttpProgress expected) {
    HttpResponse response;
    CHECK(read_http_response(bytes, is_ended, response) == expected);
    return response.body;
  };
  using enum HttpProgress;
  CHECK(read("HTTP/1.1 200 OK\r\ncontent-length:3 \r\n\r\nabcdef", false, kComplete) == "abc");
  CHECK(read("HTTP/1.0 200 OK\r\n\r\nabc", true, kComplete) == "abc");
  read("HTTP/1.0 200 OK\r\n\r\nabc", false, kIncomplete);
  read("HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nab", false, kIncomplete);
  read("HTTP/1.1 200 OK\r\nContent-Length: 3\r\n\r\nab", true, kMalformed);
  const std::string chunked = "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n";
  CHECK(read(chunked + "2\r\nab\r\nA;x=y\r\n0123456789\r\n0\r\n\r\n", false, kComplete) ==
        "ab0123456789");
  read(chunked + "2\r\nab\r\n5\r\ncd", false, kIncomplete);
  read(chunked + "2\r\nabcd\r\n0\r\n\r\n", false, kMalformed);
  read(chunked + "ffffffffffffffffff\r\n", false, kMalformed);
  read(chunked + "fffffffffffffff0\r\nab", false, kIncomplete);
  read("SSH-2.0-OpenSSH_9.2\r\n\r\n", false, kMalformed);
  read("HTTP/1.1 200 OK\r\nno colon\r\n\r\n", false, kMalformed);
  read("", true, kMalformed);
  read("", false, kIncomplete);
}

}  // namespace
}  // namespace cloister
