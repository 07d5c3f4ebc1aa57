// Handlers of /v1/comparisons/{id}/deviation.ply, .glb, .vtp and .csv: one mesh of a comparison that has ended,
// coloured by its distance from the other one.
//
// find -> (cached: send) -> admit -> make on a worker thread, once for all simultaneous requests -> send
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>

#include "server/access/access.h"
#include "server/http/connection_limit.h"
#include "server/http/exchange.h"
#include "server/jobs/jobs.h"
#include "server/maps/making.h"
#include "server/maps/map_query.h"
#include "server/observe/metrics.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

class Deviations {
 public:
  // Borrows all but the first. Precondition: stores.maps is not null.
  Deviations(const Settings& settings, Jobs& jobs, const Stores& stores, Access& access, Metrics& metrics,
             MeshLoader& loader);

  ~Deviations();  // waits for running tasks. Precondition: no call of get() is running
  Deviations(const Deviations&) = delete;
  Deviations& operator=(const Deviations&) = delete;

  // May throw: out of memory.
  void get(Exchange& exchange, MapKind kind);

 private:
  struct MapRequest;
  class Watching;
  // What the response says of a map.
  struct Label {
    std::string etag;
    MapQuery query;
    std::string job;
  };

  std::variant<MapRequest, api::Problem> find(const Exchange& exchange, MapKind kind);
  std::variant<MeshSource, api::Problem> open(const std::string& owner, const std::string& part, const std::string& id);
  std::optional<api::Problem> touch_if_stored(MeshSource& source, const std::string& owner);
  std::optional<api::Problem> open_meshes(MapRequest& request);
  void make(Exchange& exchange, MapRequest& request);
  std::optional<Clock::time_point> look(Exchange& exchange, const Label& label, const Making& making);
  void fail(Exchange& exchange, const Error& error) const;
  std::shared_ptr<Making> begin(MapRequest& request, std::optional<Scheduler::Slot>& slot);
  void submit(const std::shared_ptr<Making>& making, Scheduler::Slot slot);
  void run(const std::shared_ptr<Making>& making, Scheduler::Slot slot);
  void leave(Making& making);
  void send(Exchange& exchange, const Label& label, const MadeFile& made);
  static void add_validators(Exchange& exchange, const std::string& etag);
  static void add_headers(Exchange& exchange, const Label& label);

  const Settings settings_;
  Jobs& jobs_;
  const Stores stores_;
  Access& access_;
  Metrics& metrics_;
  const MapTools tools_;
  ConnectionLimit sending_;  // maps being sent
  std::atomic<bool> idle_{false};
  // Every task holds a copy; when the last copy is gone, idle_ becomes true.
  std::shared_ptr<const void> works_{this, [this](const void*) { idle_.store(true); }};
  std::mutex mutex_;                                  // guards what follows, and Making::watchers
  std::map<MapKey, std::shared_ptr<Making>> making_;  // maps that clients wait for
};

}  // namespace meshgauge::server
