// Waits for clients, on one thread, so that no other thread does: accepts connections, reports which of them can be
// read or written and whose deadline has passed, and takes messages from other threads.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "api/base/descriptor.h"

namespace meshgauge::server {

class EventLoop {
 public:
  using Clock = std::chrono::steady_clock;
  using Id = std::uint64_t;
  enum class Message { woken, returned };

  // What other threads tell the loop. It may outlive the loop. Thread safe.
  class Inbox {
   public:
    Inbox();
    void post(Id id, Message message);  // for the connection of this id, if it is still there
    void stir();                        // ends the loop's wait

   private:
    friend class EventLoop;
    std::vector<std::pair<Id, Message>> take();

    const Descriptor event_;
    std::mutex mutex_;  // guards what follows
    std::vector<std::pair<Id, Message>> messages_;
  };

  // A connection. The loop owns it and calls it on its thread. Each call to ready() or late() answers one want() or
  // set_deadline(), which the connection then repeats if it goes on waiting. Wanting the same again is free.
  class Source {
   public:
    Source(EventLoop& loop, Id id, Descriptor socket) : loop_(loop), id_(id), socket_(std::move(socket)) {}
    virtual ~Source() = default;
    Source(const Source&) = delete;
    Source& operator=(const Source&) = delete;

    virtual void start() = 0;
    virtual void ready() = 0;                // the socket has an event that want() named, or has failed
    virtual void late() = 0;                 // its deadline has passed
    virtual void take(Message message) = 0;  // from the inbox
    virtual void stop() = 0;                 // the service stops; aborting(): no client is waited for any more
    // Asked of when connections run out: it may be closed, since no request is being served.
    virtual bool spare() const = 0;
    // The same of one that is not spare: since when its client has taken nothing of a response; max(): it takes, or
    // there is none. It may be closed after give_way().
    virtual Clock::time_point stalled_since() const { return Clock::time_point::max(); }
    virtual void give_way() {}

   protected:
    int fd() const { return socket_.get(); }
    Id id() const { return id_; }
    EventLoop& loop() const { return loop_; }
    void want(std::uint32_t events);            // of epoll, for the next ready()
    void soon();                                // ready() is called in the next round
    void set_deadline(Clock::time_point when);  // max(): none
    void count_refusal() { ++loop_.refused_; }  // of a request, for want of room
    void set_unfinished(bool unfinished);       // not shaken hands yet
    void close() { closed_ = true; }            // destroys this object after the present call

   private:
    friend class EventLoop;
    EventLoop& loop_;
    const Id id_;
    const Descriptor socket_;
    Clock::time_point deadline_ = Clock::time_point::max();
    std::uint32_t wanted_ = 0;  // 0: nothing
    std::uint32_t armed_ = 0;   // what the kernel looks for
    bool watched_ = false;
    bool closed_ = false;
  };
  using Make = std::function<std::unique_ptr<Source>(Id id, Descriptor socket)>;

  // `make`: makes the connection of an accepted socket. `most`: number of connections; beyond it the oldest that is
  // spare gives way (of those that are unfinished, while these are more than a quarter); else the one that has stalled
  // for longest, a second at least; and a new one is closed if there is none.
  EventLoop(Make make, std::size_t most);

  // Serves the listening socket until stop(), or until the socket fails, and the connections until the last has ended.
  void run(Descriptor listener);

  void stop();   // refuses new connections. Thread safe, as all that follows
  void abort();  // waits for no client any more
  bool stopping() const { return stopping_.load(); }
  bool aborting() const { return aborting_.load(); }
  std::uint64_t size() const { return size_.load(); }        // connections
  std::uint64_t dropped() const { return dropped_.load(); }  // closed without a response, since the start
  const std::shared_ptr<Inbox>& inbox() const { return inbox_; }

 private:
  using Sources = std::map<Id, std::unique_ptr<Source>>;  // the oldest first

  bool accept_some();
  void add(Descriptor socket);
  bool drop_one();
  Sources::iterator longest_stalled();
  void read_inbox();
  void end_if_stopping();
  void scan(Clock::time_point now);
  void tell_ready(Source& source);
  void gather();
  int wait_ms(Clock::time_point now) const;
  template <class Call>
  void call(Id id, const Call& what);
  void forget(Id id);

  const Make make_;
  const std::size_t most_;
  const std::shared_ptr<Inbox> inbox_ = std::make_shared<Inbox>();
  const Descriptor epoll_;
  Descriptor listener_;
  Sources sources_;
  std::set<Id> unfinished_;  // of them
  std::vector<Id> soon_;
  Id last_id_;
  Clock::time_point next_scan_ = Clock::time_point::max();  // the earliest deadline, or later by kScanGap
  Clock::time_point last_scan_{};
  int refused_ = 0;  // requests, since counted_since_
  Clock::time_point counted_since_{}, overloaded_until_{};
  bool listening_ = false;  // false while no descriptor is left
  bool told_stop_ = false;
  bool told_abort_ = false;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> aborting_{false};
  std::atomic<std::uint64_t> size_{0};
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace meshgauge::server
