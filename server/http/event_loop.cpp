#include "server/http/event_loop.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <thread>

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

constexpr EventLoop::Id kListener = 0, kInbox = 1;
constexpr milliseconds kScanGap{20};    // between two looks at all deadlines: ten thousand take half a millisecond
constexpr milliseconds kRetryGap{100};  // while no descriptor is left
constexpr int kMostAccepted = 256;      // in one round, so that requests do not wait for a flood of connections
// Under overload, that is, for 10 ms after so many requests were refused within 10 ms, each round begins later. So one
// wake-up serves many requests, and the processor is left to those that were accepted.
constexpr int kManyRefused = 8;
constexpr milliseconds kRefusedWithin{10};
constexpr milliseconds kGather{2};
constexpr milliseconds kStalled{1'000};      // by which a client may be late before another one gets its place
constexpr std::size_t kShareUnfinished = 4;  // one in so many may be unfinished before these give way first

bool tell(int epoll, int how, int fd, EventLoop::Id id, std::uint32_t events) {
  epoll_event event{};
  event.events = events;
  event.data.u64 = id;
  return ::epoll_ctl(epoll, how, fd, &event) == 0;
}

Descriptor checked(int fd) {
  if (fd < 0) throw std::system_error(errno, std::generic_category(), "no descriptor for the event loop");
  return Descriptor(fd);
}

// A failed accept that says nothing about the listening socket (accept(2)).
bool is_passing(int error) {
  constexpr std::array kPassing{EAGAIN,      EINTR,     ECONNABORTED, EPERM,        ENETDOWN,   EPROTO,
                                ENOPROTOOPT, EHOSTDOWN, ENONET,       EHOSTUNREACH, EOPNOTSUPP, ENETUNREACH};
  return std::find(kPassing.begin(), kPassing.end(), error) != kPassing.end();
}

bool has_arrived(int listener) {
  pollfd entry{listener, POLLIN, 0};
  return ::poll(&entry, 1, 0) > 0;
}

bool is_shortage(int error) { return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM; }

}  // namespace

EventLoop::Inbox::Inbox() : event_(checked(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC))) {}

void EventLoop::Inbox::post(Id id, Message message) {
  {
    const std::lock_guard lock(mutex_);
    messages_.emplace_back(id, message);
    if (messages_.size() > 1) return;  // the loop has been stirred already
  }
  stir();
}

void EventLoop::Inbox::stir() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written =
      ::write(event_.get(), &one, sizeof one);  // fails only if the loop is stirred anyway
}

std::vector<std::pair<EventLoop::Id, EventLoop::Message>> EventLoop::Inbox::take() {
  std::uint64_t count = 0;
  [[maybe_unused]] const auto taken = ::read(event_.get(), &count, sizeof count);
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

void EventLoop::Source::want(std::uint32_t events) {
  wanted_ = events;
  if (std::exchange(armed_, events) == events) return;
  const int how = std::exchange(watched_, true) ? EPOLL_CTL_MOD : EPOLL_CTL_ADD;
  if (!tell(loop_.epoll_.get(), how, fd(), id_, events)) close();  // no memory in the kernel
}

// An event that is not wanted any more is switched off. Errors cannot be, but the first one disarms what is one-shot.
void EventLoop::tell_ready(Source& source) {
  if (std::exchange(source.wanted_, 0) != 0) return source.ready();
  if (std::exchange(source.armed_, 0) == 0) return;
  tell(epoll_.get(), EPOLL_CTL_MOD, source.fd(), source.id_, EPOLLONESHOT);
}

void EventLoop::Source::soon() { loop_.soon_.push_back(id_); }

void EventLoop::Source::set_deadline(Clock::time_point when) {
  deadline_ = when;
  loop_.next_scan_ = std::min(loop_.next_scan_, std::max(when, loop_.last_scan_ + kScanGap));
}

void EventLoop::Source::set_unfinished(bool unfinished) {
  if (unfinished) {
    loop_.unfinished_.insert(id_);
  } else {
    loop_.unfinished_.erase(id_);
  }
}

EventLoop::EventLoop(Make make, std::size_t most)
    : make_(std::move(make)), most_(most), epoll_(checked(::epoll_create1(EPOLL_CLOEXEC))), last_id_(kInbox) {
  if (!tell(epoll_.get(), EPOLL_CTL_ADD, inbox_->event_.get(), kInbox, EPOLLIN)) {
    throw std::system_error(errno, std::generic_category(), "the event loop cannot begin");
  }
}

void EventLoop::stop() {
  stopping_.store(true);
  inbox_->stir();
}

void EventLoop::abort() {
  aborting_.store(true);
  inbox_->stir();
}

void EventLoop::run(Descriptor listener) {
  listener_ = std::move(listener);
  listening_ = tell(epoll_.get(), EPOLL_CTL_ADD, listener_.get(), kListener, EPOLLIN);
  if (!listening_) stopping_.store(true);
  std::array<epoll_event, 256> events;
  for (;;) {
    end_if_stopping();
    if (stopping() && sources_.empty()) break;
    const int count = ::epoll_wait(epoll_.get(), events.data(), events.size(), wait_ms(Clock::now()));
    const std::vector<Id> soon = std::exchange(soon_, {});
    bool more = count == static_cast<int>(events.size());
    for (int i = 0; i < count; ++i) {
      const Id id = events[static_cast<std::size_t>(i)].data.u64;
      if (id == kListener) {
        more |= accept_some();
      } else if (id != kInbox) {
        call(id, [this](Source& source) { tell_ready(source); });
      }
    }
    read_inbox();
    for (const Id id : soon) call(id, [](Source& source) { source.ready(); });
    if (const auto now = Clock::now(); now >= next_scan_) scan(now);
    if (!more) gather();
  }
  listener_.close();
}

void EventLoop::gather() {
  const auto now = Clock::now();
  if (refused_ >= kManyRefused) {
    if (now - counted_since_ < kRefusedWithin) overloaded_until_ = now + kRefusedWithin;
    counted_since_ = now;
    refused_ = 0;
  }
  if (now < overloaded_until_) std::this_thread::sleep_for(kGather);
}

int EventLoop::wait_ms(Clock::time_point now) const {
  if (!soon_.empty()) return 0;
  if (next_scan_ == Clock::time_point::max()) return -1;
  const auto left = std::chrono::ceil<milliseconds>(next_scan_ - now);
  return static_cast<int>(std::clamp(left, milliseconds(0), milliseconds(60'000)).count());
}

template <class Call>
void EventLoop::call(Id id, const Call& what) {
  const auto found = sources_.find(id);
  if (found == sources_.end()) return;
  try {
    what(*found->second);
  } catch (const std::exception&) {  // out of memory: only this connection is lost
    found->second->close();
  }
  if (found->second->closed_) forget(id);
}

void EventLoop::forget(Id id) {
  sources_.erase(id);
  unfinished_.erase(id);
  size_.store(sources_.size());
}

// True: more may have arrived.
bool EventLoop::accept_some() {
  for (int i = 0; i < kMostAccepted && !stopping(); ++i) {
    const int fd = ::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd >= 0) {
      add(Descriptor(fd));
      continue;
    }
    if (errno == EAGAIN) return false;
    if (is_passing(errno)) continue;
    if (!is_shortage(errno)) return stop(), false;
    if (!has_arrived(listener_.get())) return false;  // without a descriptor, accept() does not look
    if (drop_one()) continue;
    tell(epoll_.get(), EPOLL_CTL_MOD, listener_.get(), kListener, 0);
    listening_ = false;
    next_scan_ = std::min(next_scan_, Clock::now() + kRetryGap);
    return false;
  }
  return true;
}

void EventLoop::add(Descriptor socket) {
  if (sources_.size() >= most_ && !drop_one()) {
    ++dropped_;
    return;
  }
  const Id id = ++last_id_;
  try {
    sources_.emplace(id, make_(id, std::move(socket)));
  } catch (const std::exception&) {  // out of memory
    ++dropped_;
    return;
  }
  size_.store(sources_.size());
  call(id, [](Source& source) { source.start(); });
}

// Returns end() if none has stalled for a second.
EventLoop::Sources::iterator EventLoop::longest_stalled() {
  const auto since = [](const auto& entry) { return entry.second->stalled_since(); };
  const auto found = std::ranges::min_element(sources_, {}, since);
  return found != sources_.end() && since(*found) <= Clock::now() - kStalled ? found : sources_.end();
}

// Closes the oldest connection that serves no request; while more than a quarter have not shaken hands yet, the oldest
// of these: connections that cost their clients nothing take no more than that from others, and those that do shake
// hands find room beside idle ones. Where all serve a request, the one whose client has taken nothing for longest.
// False: there is none.
bool EventLoop::drop_one() {
  const auto is_spare = [](const auto& entry) { return entry.second->spare(); };
  const bool many = unfinished_.size() > sources_.size() / kShareUnfinished;
  auto found = many ? sources_.find(*unfinished_.begin()) : std::find_if(sources_.begin(), sources_.end(), is_spare);
  if (found == sources_.end()) found = longest_stalled();
  if (found == sources_.end()) return false;
  ++dropped_;
  found->second->give_way();
  forget(found->first);
  return true;
}

void EventLoop::read_inbox() {
  for (const auto& [id, message] : inbox_->take()) {
    call(id, [message = message](Source& source) { source.take(message); });
  }
}

// Tells all connections once of each.
void EventLoop::end_if_stopping() {
  const bool aborts = aborting() && !std::exchange(told_abort_, aborting());
  const bool stops = stopping() && !std::exchange(told_stop_, stopping());
  if (stops) {
    tell(epoll_.get(), EPOLL_CTL_DEL, listener_.get(), kListener, 0);
    listener_.close();  // refuses new clients at once: in the queue of an open socket they would wait until the end
  }
  if (!stops && !aborts) return;
  std::vector<Id> all;
  for (const auto& [id, source] : sources_) all.push_back(id);
  for (const Id id : all) call(id, [](Source& source) { source.stop(); });
}

void EventLoop::scan(Clock::time_point now) {
  last_scan_ = now;
  next_scan_ = Clock::time_point::max();
  if (!listening_ && !stopping()) listening_ = tell(epoll_.get(), EPOLL_CTL_MOD, listener_.get(), kListener, EPOLLIN);
  std::vector<Id> late;
  auto next = Clock::time_point::max();
  for (const auto& [id, source] : sources_) {
    if (source->deadline_ <= now) {
      source->deadline_ = Clock::time_point::max();
      late.push_back(id);
    } else {
      next = std::min(next, source->deadline_);
    }
  }
  if (next != Clock::time_point::max()) next_scan_ = std::min(next_scan_, std::max(next, now + kScanGap));
  for (const Id id : late) call(id, [](Source& source) { source.late(); });
}

}  // namespace meshgauge::server
