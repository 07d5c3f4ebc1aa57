#include "check/remote.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <deque>
#include <exception>
#include <functional>
#include <iterator>
#include <mutex>
#include <numeric>
#include <optional>
#include <span>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "api/base/digest.h"
#include "api/base/refused.h"
#include "api/base/whole_file.h"
#include "check/remote/address.h"
#include "check/remote/answer.h"
#include "check/remote/batch.h"
#include "check/remote/client.h"
#include "check/remote/pair.h"
#include "check/remote/sender.h"
#include "check/text.h"

namespace meshgauge::check::service {
namespace {

constexpr std::size_t kMostOfBatch = 1000;
constexpr int kAttempts = 3;  // maximum number of batches in a row that bring no result

// State that all gates of a run share. Thread safe.
struct Shared {
  Shared(const RemoteOptions& options, const std::string& base, std::string its_run)
      : client(options, base),
        sender(client),
        at_once(std::max(1U, options.at_once)),
        batch_begun(options.batch_begun),
        run(std::move(its_run)) {}

  // Returns a new Idempotency-Key that no other run has.
  std::string next_key() { return "check-" + run + "-" + std::to_string(++keys); }

  Client client;
  Sender sender;
  const unsigned at_once;
  const std::function<void(const std::string& link)> batch_begun;
  const std::string run;
  std::atomic<unsigned> keys{0};
  std::mutex sending;  // held by the group of gates whose meshes are being uploaded; the next group uploads meanwhile
};

// Measures gates by a service, as batches.
//
//   store all meshes, several at once -> Batch -> each result as it comes
//
// A refused batch is cut in halves, down to the gate that is refused. Gates whose batch or results get lost are
// submitted again.
//
// Borrows all arguments.
class Together {
 public:
  Together(Shared& shared, std::span<const Task> tasks) : shared_(shared), tasks_(tasks), reported_(tasks.size(), 0) {
    for (const Task& task : tasks) pairs_.emplace_back(shared.sender, *task.gate, *task.control);
  }

  // Blocks until all gates have ended. Call once.
  void measure() {
    Places all(tasks_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    ask(sent(all));
  }

 private:
  using Places = std::vector<std::size_t>;  // indices of gates

  // Returns the gates whose meshes are stored; the others have ended.
  Places sent(const Places& places) {
    const std::lock_guard lock(shared_.sending);
    each(places, [&](std::size_t place) {
      if (auto ok = pairs_[place].send(); !ok) tell(place, std::move(ok).error());
    });
    return left_of(places);
  }

  // Precondition: the meshes of these gates are stored.
  void ask(Places places) {
    using Fate = Batch::Fate;
    for (int attempt = 1; !places.empty(); ++attempt) {
      const auto [fate, error] = ask_once(places);
      const Places left = left_of(places);
      if (left.empty()) return;
      if (left.size() < places.size()) attempt = 0;
      const bool lost = fate == Fate::lost || fate == Fate::unknown_mesh;
      if (!lost || attempt == kAttempts) {
        if (left.size() > 1 && (fate == Fate::refused || fate == Fate::unknown_mesh)) return halve(left);
        for (const std::size_t place : left) tell(place, error);
        return;
      }
      shared_.sender.doubt();
      places = sent(left);
    }
  }

  Batch::Outcome ask_once(const Places& places) {
    std::vector<Pair*> pairs;
    for (const std::size_t place : places) {
      pairs.push_back(&pairs_[place]);
      pairs.back()->report({0, Progress{}.upper, "queue"});
    }
    Control& control = *tasks_[places.front()].control;
    const auto begun = [this](const std::string& view) {
      if (shared_.batch_begun) shared_.batch_begun(link_to(shared_.client.base(), view));
    };
    const auto ended = [&](std::size_t place, End end) { tell(places[place], std::move(end)); };
    return Batch(shared_.client, std::move(pairs), shared_.next_key(), control, {begun, ended}).measure();
  }

  // Submits the halves of a refused batch.
  void halve(const Places& places) {
    const auto middle = places.begin() + static_cast<std::ptrdiff_t>(places.size() / 2);
    ask({places.begin(), middle});
    ask({middle, places.end()});
  }

  Places left_of(const Places& places) const {
    Places left;
    std::copy_if(places.begin(), places.end(), std::back_inserter(left),
                 [&](std::size_t i) { return reported_[i] == 0; });
    return left;
  }

  // Runs `work` for all gates, on as many threads as may send at the same time.
  void each(const Places& places, const std::function<void(std::size_t place)>& work) {
    std::atomic<std::size_t> next{0};
    const auto some = [&] {
      for (std::size_t i = next++; i < places.size(); i = next++) {
        try {
          work(places[i]);
        } catch (const std::exception& error) {
          const std::string what = std::string("the measurement failed unexpectedly: ") + error.what();
          if (reported_[places[i]] == 0) tell(places[i], Error{ErrorCode::internal, what, "", ""});
        }
      }
    };
    std::vector<std::jthread> threads;
    try {
      while (threads.size() + 1 < std::min<std::size_t>(shared_.at_once, places.size())) threads.emplace_back(some);
    } catch (const std::system_error&) {  // continue with fewer threads
    }
    some();
  }

  void tell(std::size_t place, End end) {
    const Task& task = tasks_[place];
    const std::string& base = shared_.client.base();
    if (!end.document) {
      const bool stopped = task.control->check() == Interruption::cancelled;
      return tell(place, stopped ? cancelled() : error_of(*end.problem, *task.gate, base));
    }
    const auto took = tasks_.size() > 1 ? run_ms(*end.document) : std::nullopt;  // one gate's time includes waiting
    // Removed, since the document must not depend on whether a service measured.
    const std::string view = take_view(*end.document);
    auto measured = measured_from(*std::move(end.document), *task.gate);
    if (measured && !view.empty()) measured->link = link_to(base, view);
    tell(place, std::move(measured), took);
  }

  void tell(std::size_t place, Result<Measured> result, std::optional<double> run_ms = {}) {
    reported_[place] = 1;
    tasks_[place].ended(std::move(result), run_ms);
  }

  Shared& shared_;
  const std::span<const Task> tasks_;
  std::deque<Pair> pairs_;
  std::vector<char> reported_;  // not vector<bool>: threads write single elements
};

}  // namespace
}  // namespace meshgauge::check::service

namespace meshgauge::check {
namespace {

constexpr std::size_t kMostKeyBytes = 4096;

class Remote final : public Measurer {
 public:
  Remote(const RemoteOptions& options, const std::string& base) : shared_(options, base, api::random_id()) {}

  unsigned at_once() const override { return shared_.at_once; }
  std::size_t together() const override { return service::kMostOfBatch; }
  void measure(std::span<const Task> tasks) override { service::Together(shared_, tasks).measure(); }

 private:
  service::Shared shared_;
};

Error no_key(const std::string& why) { return bad_flag("--key-file", "the key " + why); }

}  // namespace

Result<std::unique_ptr<Measurer>> remote(const RemoteOptions& options) {
  const auto base = service::base_of(options.url);
  if (!base) return base.error();
  if (!options.key.empty() && !service::is_key(options.key)) {
    return no_key("must be one line of visible ASCII");
  }
  if (!options.key.empty() && !options.key_in_clear && !service::is_private(*base)) {
    return no_key("would be readable on its way to " + *base + ": use https, or add --key-in-clear");
  }
  std::unique_ptr<Measurer> made = std::make_unique<Remote>(options, *base);
  return made;
}

Result<std::string> service_key(const std::filesystem::path& file) {
  if (file.empty()) {
    const char* variable = std::getenv("MESHGAUGE_KEY");
    return std::string(trimmed(variable ? variable : ""));
  }
  const auto text = api::read_text_file(file.string(), kMostKeyBytes);
  if (!text) return bad_flag("--key-file", "'" + file.string() + "': " + text.error().message);
  std::string key(trimmed(*text));
  if (service::is_key(key)) return key;
  return no_key("in '" + file.string() + "' must be one line of visible ASCII");
}

}  // namespace meshgauge::check
