// The calls of tools that run at the same time, on a few threads; others wait.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "engine/control.h"

namespace meshgauge::mcp {

// begin(), end() and the destructor belong to one thread, cancel() and running() to any.
class Calls {
 public:
  // Returns the answer; empty: there is none. `control` is cancelled by cancel() and end(). What throws has no answer.
  using Work = std::function<std::string(Control& control)>;
  // Takes the answer of a call that was not cancelled, when its id is free. Called on any thread.
  using Send = std::function<void(std::string answer)>;

  struct Most {
    std::size_t calls = 256;
    std::size_t bytes = 0;  // of all messages together
  };

  // Without threads, or when the system refuses them, begin() itself runs a call.
  Calls(unsigned threads, const Most& most, Send send);
  Calls(const Calls&) = delete;
  Calls& operator=(const Calls&) = delete;
  ~Calls();  // cancels all calls, and waits for those that run

  enum class Begun { yes, same_id, too_many };

  // `bytes`: of the message. too_many: the work was not taken.
  Begun begin(const std::string& id, std::size_t bytes, Work work);
  // A call that waits is gone then; one that runs is when it has ended. Does nothing when there is no such call.
  void cancel(const std::string& id);
  std::size_t running() const;

  // Cancels all calls; those that wait do not begin. Returns whether all have ended within `patience`; a call that
  // reads a file ends when it is read.
  bool end(std::chrono::milliseconds patience);

 private:
  struct Call {
    std::string id;
    std::size_t bytes = 0;
    Work work;
    Control control;
  };

  void serve();
  void run(Call& call);            // counts in running_ already
  void release(const Call& call);  // precondition of this and the next: mutex_ is held
  void stop();

  const Most most_;
  const Send send_;
  mutable std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::map<std::string, std::shared_ptr<Call>> calls_;  // that wait or run, by id
  std::deque<std::shared_ptr<Call>> waiting_;
  std::size_t bytes_ = 0;
  std::size_t running_ = 0;
  bool is_ending_ = false;
  std::vector<std::thread> threads_;  // last member: they use all members above
};

}  // namespace meshgauge::mcp
