#include "check/remote/together.h"

#include <algorithm>
#include <exception>
#include <iterator>
#include <numeric>
#include <system_error>
#include <thread>
#include <utility>

#include "check/remote/address.h"
#include "check/remote/answer.h"
#include "check/remote/comparison.h"
#include "check/remote/waiting.h"

namespace meshgauge::check::service {

using Json = nlohmann::ordered_json;

Result<Measured> measured_of(const Shared& shared, const Pair& pair, Result<Json> document) {
  if (!document) return document.error();
  // Removed, since the document must not depend on whether a service measured.
  const std::string view = take_view(*document);
  auto measured = measured_from(std::move(*document), pair.gate());
  if (measured && !view.empty()) measured->link = link_to(shared.client.base(), view);
  return measured;
}

Together::Together(Shared& shared, std::span<const Task> tasks)
    : shared_(shared), tasks_(tasks), reported_(tasks.size(), 0) {
  for (const Task& task : tasks) pairs_.emplace_back(shared.sender, *task.gate, *task.control);
}

void Together::measure() {
  Places all(tasks_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  ask(sent(all));
}

// Returns the gates whose meshes are stored; the others have ended.
Together::Places Together::sent(const Places& places) {
  const std::lock_guard lock(shared_.sending);
  each(places, [&](std::size_t place) {
    if (auto ok = pairs_[place].send(); !ok) tell(place, std::move(ok).error());
  });
  return left_of(places);
}

void Together::ask(Places places) {
  bool sent_again = false;
  for (int attempt = 1;; ++attempt) {
    if (places.size() < 2 || shared_.most_of_batch == 1) return ask_alone(places);
    const auto outcome = ask_once(places);
    places = left_of(places);
    switch (outcome.fate) {
      case Batch::Fate::ended:
        return ask_alone(places);
      case Batch::Fate::absent:
        shared_.most_of_batch = 1;
        return ask_alone(places);
      case Batch::Fate::refused:
        return halve(places);
      case Batch::Fate::failed:
        for (const std::size_t place : places) tell(place, *outcome.error);
        return;
      case Batch::Fate::cancelled:
        for (const std::size_t place : places) tell(place, cancelled());
        return;
      case Batch::Fate::unknown_mesh:
        if (std::exchange(sent_again, true)) return ask_alone(places);
        break;
      case Batch::Fate::lost:
        if (attempt >= kAttempts) return ask_alone(places);
        break;
    }
    shared_.sender.doubt();
    places = sent(places);
  }
}

Batch::Outcome Together::ask_once(const Places& places) {
  std::vector<const Pair*> pairs;
  for (const std::size_t place : places) {
    tasks_[place].control->report({0, Progress{}.upper, "queue"});
    pairs.push_back(&pairs_[place]);
  }
  const auto ended = [&](std::size_t i, End end) { tell(places[i], std::move(end)); };
  const auto begun = [&](const std::string& view) {
    if (shared_.batch_begun) shared_.batch_begun(link_to(shared_.client.base(), view));
  };
  Control& control = *tasks_[places.front()].control;
  return Batch(shared_.client, std::move(pairs), shared_.next_key(), control, ended, begun).measure();
}

// Submits the halves of a refused batch, down to the single gate that is refused.
void Together::halve(const Places& places) {
  const auto middle = places.begin() + static_cast<std::ptrdiff_t>(places.size() / 2);
  ask({places.begin(), middle});
  ask({middle, places.end()});
}

void Together::ask_alone(const Places& places) {
  each(places, [&](std::size_t place) {
    Control& control = *tasks_[place].control;
    Comparison comparison(shared_.client, shared_.limit, pairs_[place], shared_.next_key(), control);
    tell(place, measured_of(shared_, pairs_[place], comparison.measure()));
  });
}

Together::Places Together::left_of(const Places& places) const {
  Places left;
  std::copy_if(places.begin(), places.end(), std::back_inserter(left),
               [&](std::size_t i) { return reported_[i] == 0; });
  return left;
}

// Runs `work` for all gates, on as many threads as the service may be asked by.
void Together::each(const Places& places, const std::function<void(std::size_t place)>& work) {
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
    while (threads.size() + 1 < std::min<std::size_t>(shared_.limit.most(), places.size())) threads.emplace_back(some);
  } catch (const std::system_error&) {  // continue with fewer threads
  }
  some();
}

void Together::tell(std::size_t place, End end) {
  if (end.document) {
    const auto took = run_ms(*end.document);
    return tell(place, measured_of(shared_, pairs_[place], std::move(*end.document)), took);
  }
  if (tasks_[place].control->check() == Interruption::cancelled) return tell(place, cancelled());
  tell(place, error_of(*end.problem, *tasks_[place].gate, shared_.client.base()));
}

void Together::tell(std::size_t place, Result<Measured> result, std::optional<double> run_ms) {
  reported_[place] = 1;
  tasks_[place].ended(std::move(result), run_ms);
}

}  // namespace meshgauge::check::service
