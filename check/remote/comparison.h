// One gate at the service: asked for, followed to its end, or given up.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "check/gate.h"
#include "check/remote/answer.h"
#include "check/remote/client.h"
#include "check/remote/seats.h"
#include "check/remote/sender.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// Borrows all.
class Comparison {
 public:
  // `max_distance`: the gate's limit, in the meshes' unit. `key`: no other gate of any run has it.
  Comparison(Client& client, Sender& sender, Seats& seats, const Gate& gate, double max_distance, std::string key,
             Control& control)
      : client_(client),
        sender_(sender),
        seats_(seats),
        gate_(gate),
        max_distance_(max_distance),
        key_(std::move(key)),
        control_(control) {}

  // The document of the comparison. Once.
  Result<nlohmann::ordered_json> measure();

 private:
  using Clock = Control::Clock;

  // What came of asking once: a document, or why there is none.
  struct End {
    std::optional<nlohmann::ordered_json> document;
    std::optional<Problem> problem;
    bool lost = false;  // the service does not know the comparison any more
  };

  // One of the two meshes, as the service is asked about it.
  struct Mesh {
    std::string id;
    bool forgotten = false;   // it is to be sent without asking
    bool sent_again = false;  // that was done
  };

  Result<Done> send();
  Result<Done> send(Mesh& mesh, Sender::Part part);
  Result<End> attempt();
  Call call(int wait) const;
  Result<End> answered(const Reply& reply);
  Result<End> follow(const std::string& id);
  bool learn(Job job, End& end);
  Result<End> cancel(const std::string& id, const Interrupted& over);
  Result<End> abandon(const Error& why);
  bool pause(std::chrono::milliseconds time);
  bool again(const End& end);
  bool forget(const std::string& part);
  bool is_ours(const nlohmann::ordered_json& document) const;
  Error unexpected(const Reply& reply) const;

  Client& client_;
  Sender& sender_;
  Seats& seats_;
  const Gate& gate_;
  const double max_distance_;
  const std::string key_;
  Control& control_;
  std::string document_;  // what is asked for
  int attempts_ = 0;
  Mesh a_, b_;
  Progress progress_;
};

}  // namespace meshgauge::check::service
