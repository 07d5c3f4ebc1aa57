// Several gates at the service by one request: asked for, followed to their end, or given up.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "check/remote/answer.h"
#include "check/remote/client.h"
#include "check/remote/pair.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

class BatchResults;

// Borrows all.
class Batch {
 public:
  // What became of it. Whatever it is, pairs that were told of have ended.
  enum class Fate {
    ended,         // what was not told of has no result there any more
    absent,        // the service has no batches
    unknown_mesh,  // it has not all meshes
    refused,       // it is too large, or one of its pairs is not taken
    lost,          // the service does not know it any more
    failed,        // by `error`
    cancelled,
  };
  struct Outcome {
    Fate fate = Fate::ended;
    std::optional<Error> error;
  };
  // Once for each place in `pairs`, on the thread of measure(): how it ended.
  using Told = std::function<void(std::size_t place, End end)>;

  // Once at most, likewise: it is accepted, and a browser sees it at this path of the service.
  using Begun = std::function<void(const std::string& view)>;

  // Precondition: the pairs were sent, and there are some. `key`: no other batch of any run has it. `control` is
  // cancelled with those of all pairs.
  Batch(Client& client, std::vector<const Pair*> pairs, std::string key, Control& control, Told told, Begun begun)
      : client_(client),
        pairs_(std::move(pairs)),
        key_(std::move(key)),
        control_(control),
        tell_(std::move(told)),
        begun_(std::move(begun)),
        reported_(pairs_.size(), false) {}

  // Once.
  Outcome measure();

 private:
  using Clock = Control::Clock;

  std::string document() const;
  HttpRequest request() const;
  Outcome answered(const HttpAnswer& reply);
  Outcome failed(const HttpAnswer& reply) const;
  Outcome follow(const std::string& id);
  std::optional<BatchState> ours(const HttpAnswer& reply) const;
  bool due(const BatchState& batch) const;
  std::chrono::milliseconds longest() const;
  Result<Done> read(const std::string& id);
  HttpRequest results_request(const std::string& id, BatchResults& results) const;
  void learn(BatchLine line);
  Outcome abandon();
  Outcome cancel(const std::string& id);
  void end_there(const std::string& id, const Interrupted& over);

  Client& client_;
  const std::vector<const Pair*> pairs_;
  const std::string key_;
  Control& control_;
  const Told tell_;
  const Begun begun_;
  std::string document_;  // what is asked for
  std::vector<bool> reported_;
  std::size_t known_ = 0;   // of them
  Clock::time_point read_;  // when results were read
};

}  // namespace meshgauge::check::service
