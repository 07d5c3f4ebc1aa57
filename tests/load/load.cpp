// A client that loads a service and tells what became of every request: one thread, one epoll, requests that were
// written beforehand, so that it takes little of the processors that it shares with the service.
//
//   load --port N --seconds S (--connections N | --rate R) --out FILE REQUEST[=WEIGHT] ...
//
// Closed loop (--connections): so many clients, each sends its next request when it has the answer to the last.
// Open loop (--rate): requests are due at random times (Poisson) whatever became of the others, and each latency counts
// from the time when its request was due, so that a service that stalls is not spared the requests that came meanwhile.
//
// REQUEST is a file with a whole HTTP request; with "Expect: 100-continue" its body waits for that response. The rows
// of FILE: when it was due (s), latency from then (s), from when it was sent (s), status (below 0: no answer), which
// REQUEST (from 0), whether it had to be sent again.
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <deque>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#include "response.h"

namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr int kNotConnected = -1, kUnanswered = -3, kNotSent = -4;  // beside kBroken
constexpr std::chrono::microseconds kLookGap{200};

struct Settings {
  int port = 0;
  double seconds = 10;
  std::size_t connections = 0;
  double rate = 0;
  std::size_t most_connections = 8000;
  unsigned sources = 1;  // addresses that the clients have: 127.0.0.1, 127.0.0.2, ...
  double patience = 30;  // for answers after the last request
  unsigned seed = 1;
  std::string out;
  std::vector<std::string> requests;
};

struct Row {
  Clock::time_point due;
  Clock::time_point sent;
  Clock::time_point answered;
  int status;
  std::size_t request;
  bool again;
};

struct Request {
  std::string text;
  std::size_t unasked;  // bytes that are sent at once
};

struct Flow {  // a connection and the request on it
  int fd = -1;
  std::size_t place = 0;  // in the list of all
  bool busy = false;
  bool reused = false;  // the request is not the connection's first
  bool again = false;
  std::size_t request = 0;
  std::size_t sent_bytes = 0;
  Clock::time_point due;
  Clock::time_point sent;
  Response response;
};

class Client {
 public:
  explicit Client(Settings settings) : settings_(std::move(settings)), random_(settings_.seed) {
    for (const std::string& text : settings_.requests) add_request(text);
    choice_ = std::discrete_distribution<std::size_t>(weights_.begin(), weights_.end());
    epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
  }

  void run() {
    start_ = Clock::now();
    end_ = start_ + std::chrono::duration_cast<Clock::duration>(Seconds(settings_.seconds));
    if (settings_.rate > 0) due_ = start_ + gap();
    for (std::size_t i = 0; i < settings_.connections; ++i) begin(Clock::now(), pick(), false);
    const auto last = end_ + std::chrono::duration_cast<Clock::duration>(Seconds(settings_.patience));
    while (Clock::now() < last && (Clock::now() < end_ || busy_ > 0)) {
      begin_what_is_due();
      advance_what_is_ready();
      std::this_thread::sleep_for(kLookGap);
    }
    for (const auto& flow : flows_) {
      if (flow->busy) rows_.push_back({flow->due, flow->sent, Clock::now(), kUnanswered, flow->request, flow->again});
    }
  }

  bool write() const {
    std::FILE* file = std::fopen(settings_.out.c_str(), "w");
    if (!file) return false;
    std::fputs("due,latency,service,status,request,again\n", file);
    for (const Row& row : rows_) {
      std::fprintf(file, "%.6f,%.6f,%.6f,%d,%zu,%d\n", Seconds(row.due - start_).count(),
                   Seconds(row.answered - row.due).count(), Seconds(row.answered - row.sent).count(), row.status,
                   row.request, row.again);
    }
    return std::fclose(file) == 0;
  }

 private:
  void add_request(const std::string& text) {
    const std::size_t equals = text.rfind('=');
    std::ifstream file(text.substr(0, equals), std::ios::binary);
    std::string whole{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (whole.empty()) throw CLI::ValidationError(text, "no such request");
    const std::size_t head = whole.find("\r\n\r\n") + 4;
    const bool asks = std::string_view(whole).substr(0, head).find("\r\nExpect: ") != std::string_view::npos;
    const std::size_t unasked = asks ? head : whole.size();
    requests_.push_back({std::move(whole), unasked});
    weights_.push_back(equals == std::string::npos ? 1 : std::stod(text.substr(equals + 1)));
  }

  Clock::duration gap() {
    return std::chrono::duration_cast<Clock::duration>(
        Seconds(std::exponential_distribution<double>(settings_.rate)(random_)));
  }

  std::size_t pick() { return choice_(random_); }

  void begin_what_is_due() {
    if (settings_.rate <= 0) return;
    for (const auto now = Clock::now(); due_ <= now && due_ < end_; due_ += gap()) begin(due_, pick(), false);
  }

  // Looks again after a while instead of being woken: that would take the service's processor, as no client on another
  // machine does.
  void advance_what_is_ready() {
    std::array<epoll_event, 256> events;
    const int n = ::epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 0);
    for (int i = 0; i < n; ++i) {
      Flow& flow = *static_cast<Flow*>(events[static_cast<std::size_t>(i)].data.ptr);
      if (flow.fd >= 0) advance(flow);
    }
    dead_.clear();
  }

  void begin(Clock::time_point due, std::size_t request, bool again) {
    Flow* flow = again ? nullptr : idle_flow();
    if (!flow) flow = connect();
    if (!flow) {
      const auto now = Clock::now();
      const int status = flows_.size() >= settings_.most_connections ? kNotSent : kNotConnected;
      rows_.push_back({due, now, now, status, request, again});
      return;
    }
    flow->busy = true;
    ++busy_;
    flow->again = again;
    flow->request = request;
    flow->due = due;
    flow->sent = Clock::now();
    flow->sent_bytes = 0;
    flow->response = {};
    if (flow->reused) advance(*flow);  // a new connection says when it is ready
  }

  Flow* idle_flow() {
    if (idle_.empty()) return nullptr;
    Flow* flow = idle_.back();
    idle_.pop_back();
    flow->reused = true;
    return flow;
  }

  Flow* connect() {
    if (flows_.size() >= settings_.most_connections) return nullptr;
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) return nullptr;
    const int yes = 1;
    ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    // Ends at once, without a port that waits: there are not enough of them for every refused connection.
    const linger now{1, 0};
    ::setsockopt(fd, SOL_SOCKET, SO_LINGER, &now, sizeof now);
    if (settings_.sources > 1) {
      ::setsockopt(fd, IPPROTO_IP, IP_BIND_ADDRESS_NO_PORT, &yes, sizeof yes);
      const auto from = address(next_source_++ % settings_.sources, 0);
      ::bind(fd, reinterpret_cast<const sockaddr*>(&from), sizeof from);
    }
    const auto to = address(0, settings_.port);
    if (::connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0 && errno != EINPROGRESS) {
      ::close(fd);
      return nullptr;
    }
    flows_.push_back(std::make_unique<Flow>());
    Flow& flow = *flows_.back();
    flow.fd = fd;
    flow.place = flows_.size() - 1;
    epoll_event event{};
    event.events = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET;
    event.data.ptr = &flow;
    ::epoll_ctl(epoll_, EPOLL_CTL_ADD, fd, &event);
    return &flow;
  }

  static sockaddr_in address(unsigned offset, int port) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK + offset);
    return to;
  }

  // Reads before it writes: a service that refuses answers in the middle of a body.
  void advance(Flow& flow) {
    const bool open = receive(flow);
    if (flow.fd < 0 || !flow.busy) return;
    // If sending fails, the service may have refused the request: reads its answer before the connection is lost.
    if (!open || (!send(flow) && !answered_meanwhile(flow))) lost(flow);
  }

  // False when the connection is at its end and the response is not.
  bool receive(Flow& flow) {
    std::array<char, 65536> buffer;
    for (;;) {
      const ssize_t n = ::recv(flow.fd, buffer.data(), buffer.size(), 0);
      if (n < 0 && (errno == EAGAIN || errno == ENOTCONN)) return true;
      if (!flow.busy) return close(flow), true;  // an idle connection that the service closes
      if (n <= 0) return false;
      if (flow.response.take({buffer.data(), static_cast<std::size_t>(n)})) return answered(flow), true;
    }
  }

  bool answered_meanwhile(Flow& flow) {
    receive(flow);
    return flow.fd < 0;  // a connection whose request was not sent to its end is closed with its answer
  }

  bool send(Flow& flow) {
    const Request& request = requests_[flow.request];
    const std::size_t most = flow.response.invited() ? request.text.size() : request.unasked;
    while (flow.sent_bytes < most) {
      const ssize_t n = ::send(flow.fd, request.text.data() + flow.sent_bytes, most - flow.sent_bytes, MSG_NOSIGNAL);
      if (n < 0) return errno == EAGAIN || errno == ENOTCONN;
      flow.sent_bytes += static_cast<std::size_t>(n);
    }
    return true;
  }

  void answered(Flow& flow) {
    record(flow, flow.response.status());
    if (flow.response.closes() || flow.sent_bytes < requests_[flow.request].text.size()) {
      close(flow);
    } else {
      idle_.push_back(&flow);
    }
    if (settings_.connections > 0 && Clock::now() < end_) begin(Clock::now(), pick(), false);
  }

  // An idle connection may be closed just when it is used again; every client sends such a request once more.
  void lost(Flow& flow) {
    const bool retry = flow.reused && !flow.response.begun();
    const auto due = flow.due;
    const std::size_t request = flow.request;
    if (retry) {
      flow.busy = false;
      --busy_;
    } else {
      record(flow, kBroken);
    }
    close(flow);
    if (retry)
      begin(due, request, true);
    else if (settings_.connections > 0 && Clock::now() < end_)
      begin(Clock::now(), pick(), false);
  }

  void record(Flow& flow, int status) {
    rows_.push_back({flow.due, flow.sent, Clock::now(), status, flow.request, flow.again});
    flow.busy = false;
    --busy_;
  }

  // The flow itself goes after this round of events, some of which may still name it.
  void close(Flow& flow) {
    ::close(flow.fd);
    flow.fd = -1;
    std::erase(idle_, &flow);
    std::swap(flows_[flow.place], flows_.back());
    flows_[flow.place]->place = flow.place;
    dead_.push_back(std::move(flows_.back()));
    flows_.pop_back();
  }

  const Settings settings_;
  std::mt19937_64 random_;
  std::discrete_distribution<std::size_t> choice_;
  std::vector<Request> requests_;
  std::vector<double> weights_;
  int epoll_ = -1;
  Clock::time_point start_, end_, due_;
  unsigned next_source_ = 0;
  std::size_t busy_ = 0;
  std::vector<std::unique_ptr<Flow>> flows_;
  std::vector<std::unique_ptr<Flow>> dead_;
  std::vector<Flow*> idle_;
  std::deque<Row> rows_;
};

void raise_limit_of_files() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

// Clients are on machines of their own: where that is allowed, this one does not wait for the service's processors.
void go_first() {
  constexpr int kFirst = -19;
  [[maybe_unused]] const int refused = ::setpriority(PRIO_PROCESS, 0, kFirst);
}

}  // namespace

int main(int argc, char** argv) {
  Settings settings;
  CLI::App app("Loads a service on this machine and tells what became of every request");
  app.add_option("--port", settings.port)->required();
  app.add_option("--seconds", settings.seconds, "Time in which requests begin");
  const auto closed = app.add_option("--connections", settings.connections, "Closed loop of so many clients");
  app.add_option("--rate", settings.rate, "Open loop of so many requests a second")->excludes(closed);
  app.add_option("--most-connections", settings.most_connections);
  app.add_option("--sources", settings.sources, "Addresses that clients have, from 127.0.0.1 on")
      ->check(CLI::Range(1, 65000));
  app.add_option("--patience", settings.patience, "Seconds to wait for answers at the end");
  app.add_option("--seed", settings.seed);
  app.add_option("--out", settings.out)->required();
  app.add_option("requests", settings.requests, "FILE or FILE=WEIGHT")->required();
  CLI11_PARSE(app, argc, argv);
  raise_limit_of_files();
  go_first();
  try {
    Client client(settings);
    client.run();
    if (client.write()) return 0;
    std::perror(settings.out.c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "load: %s\n", error.what());
  }
  return 1;
}
