// Measures gates by one batch of a service: submits it, follows it to its end, or cancels it.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "check/remote/answer.h"
#include "check/remote/client.h"
#include "check/remote/pair.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// Takes a line of a batch's results. May be called again for a position: each try begins with the first line.
using BatchLineSink = std::function<void(BatchLine line)>;

// Parses the results of a batch while they stream in, one per line. Holds one line, of at most kMostReplyBytes, and
// accepts positions in rising order, at most as many as the batch has comparisons. Bytes after the last line end are
// ignored.
class BatchResults {
 public:
  BatchResults(std::size_t comparisons, BatchLineSink sink) : comparisons_(comparisons), sink_(std::move(sink)) {}

  void begin();                       // call before each try
  bool take(std::string_view piece);  // false: these are not the results of this batch

 private:
  bool take_line(std::string_view text);

  const std::size_t comparisons_;
  const BatchLineSink sink_;
  std::string line_;      // the incomplete line
  std::size_t next_ = 0;  // the lowest position that may follow
};

// Borrows the client and the control.
class Batch {
 public:
  // Why pairs have no result that was reported.
  enum class Fate {
    lost,          // the service has none, or no longer knows the batch
    unknown_mesh,  // the service lacks a mesh
    refused,       // the batch is too large, or one of its pairs is refused
    failed,        // cancelled, or the service fails
  };
  struct Outcome {
    Fate fate = Fate::lost;
    Error error;  // of these pairs; with `unknown_mesh` and `refused` it holds for a batch of one pair alone
  };
  // What happens to the batch. Called on the thread of measure().
  struct Listener {
    // Called at most once, when the batch is accepted and has a page. `view`: path of that page.
    std::function<void(const std::string& view)> begun;
    // Called at most once for each pair: how it ended. `place`: index in `pairs`.
    std::function<void(std::size_t place, End end)> ended;
  };

  // Preconditions: `pairs` is not empty and every pair is sent; no other batch of any run has `key`. `control` is
  // cancelled with those of all pairs.
  Batch(Client& client, std::vector<Pair*> pairs, std::string key, Control& control, Listener listener)
      : client_(client),
        pairs_(std::move(pairs)),
        key_(std::move(key)),
        control_(control),
        listener_(std::move(listener)),
        reported_(pairs_.size(), false) {}

  // Call once.
  Outcome measure();

 private:
  using Clock = Control::Clock;

  std::string document() const;
  HttpRequest request() const;
  Outcome answered(const HttpAnswer& reply);
  Outcome refused(const HttpAnswer& reply) const;
  Outcome failed(const HttpAnswer& reply) const;
  Outcome lost() const;
  Outcome follow(const std::string& id);
  std::optional<BatchState> ours(const HttpAnswer& reply) const;
  bool due(const BatchState& batch) const;
  std::chrono::milliseconds slack(bool runs) const;
  std::chrono::milliseconds longest() const;
  Result<Done> read(const std::string& id);
  HttpRequest results_request(const std::string& id, BatchResults& results) const;
  void take(BatchLine line);
  Outcome abandon();
  Outcome cancel(const std::string& id);
  void end_there(const std::string& id, const Interrupted& over);

  Client& client_;
  const std::vector<Pair*> pairs_;
  const std::string key_;
  Control& control_;
  const Listener listener_;
  std::string document_;  // the request
  std::vector<bool> reported_;
  std::size_t known_ = 0;   // pairs that were reported
  Clock::time_point read_;  // time of the last read of results
};

}  // namespace meshgauge::check::service
