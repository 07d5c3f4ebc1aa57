// Measures many gates by a service: as batches, and one by one where batches fail.
//
//   store all meshes, several at once -> Batch -> each result as it comes
//
// A refused batch is cut in halves, a lost one is submitted again, and a gate without a result is measured by itself.
#pragma once

#include <atomic>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "check/measurer.h"
#include "check/remote/adaptive_limit.h"
#include "check/remote/batch.h"
#include "check/remote/client.h"
#include "check/remote/pair.h"
#include "check/remote/sender.h"

namespace meshgauge::check::service {

// State that all gates of a run share. Thread safe.
struct Shared {
  Shared(const RemoteOptions& options, const std::string& base, std::string its_run)
      : client(options, base),
        sender(client),
        limit(options.at_once),
        batch_begun(options.batch_begun),
        run(std::move(its_run)) {}

  // Returns a new Idempotency-Key that no other run has.
  std::string next_key() { return "check-" + run + "-" + std::to_string(++keys); }

  Client client;
  Sender sender;
  AdaptiveLimit limit;
  const std::function<void(const std::string& link)> batch_begun;
  const std::string run;
  std::atomic<unsigned> keys{0};
  std::atomic<std::size_t> most_of_batch{1000};  // gates per batch; 1: the service has no batches
  std::mutex sending;  // held by the group of gates whose meshes are being uploaded; the next group uploads meanwhile
};

// Makes the gate's result of the service's document.
Result<Measured> measured_of(const Shared& shared, const Pair& pair, Result<nlohmann::ordered_json> document);

// Borrows all arguments.
class Together {
 public:
  Together(Shared& shared, std::span<const Task> tasks);

  // Blocks until all gates have ended. Call once.
  void measure();

 private:
  using Places = std::vector<std::size_t>;  // indices of gates

  Places sent(const Places& places);
  void ask(Places places);
  Batch::Outcome ask_once(const Places& places);
  void halve(const Places& places);
  void ask_alone(const Places& places);
  Places left_of(const Places& places) const;
  void each(const Places& places, const std::function<void(std::size_t place)>& work);
  void tell(std::size_t place, End end);
  void tell(std::size_t place, Result<Measured> result, std::optional<double> run_ms = {});

  Shared& shared_;
  const std::span<const Task> tasks_;
  std::deque<Pair> pairs_;
  std::vector<char> reported_;  // not vector<bool>: threads write single elements
};

}  // namespace meshgauge::check::service
