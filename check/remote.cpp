#include "check/remote.h"

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

#include "api/digest.h"
#include "check/remote/address.h"
#include "check/remote/answer.h"
#include "check/remote/client.h"
#include "check/remote/comparison.h"
#include "check/remote/seats.h"
#include "check/remote/sender.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

constexpr std::size_t kMostKeyBytes = 4096;

class Remote final : public Measurer {
 public:
  Remote(const RemoteOptions& options, const std::string& base)
      : client_(options, base), sender_(client_), seats_(options.at_once), run_(api::random_id()) {}

  Result<Measured> measure(const Gate& gate, Control& control) override {
    const auto limit = limit_of(gate, control);
    if (!limit) return limit.error();
    service::Comparison comparison(client_, sender_, seats_, gate, *limit, next_key(), control);
    auto document = comparison.measure();
    if (!document) return document.error();
    // Taken away, since documents are the same whoever measured.
    const std::string view = service::take_view(*document);
    auto measured = measured_from(std::move(*document), *limit);
    if (measured && !view.empty()) measured->link = service::link_to(client_.base(), view);
    return measured;
  }

  unsigned at_once() const override { return seats_.most(); }

 private:
  Result<double> limit_of(const Gate& gate, Control& control) {
    if (gate.limit.max_distance) return *gate.limit.max_distance;
    const auto diagonal = sender_.baseline_diagonal(gate, control);
    if (!diagonal) return diagonal.error();
    return max_distance(gate.limit, *diagonal);
  }

  std::string next_key() { return "check-" + run_ + "-" + std::to_string(++gates_); }

  service::Client client_;
  service::Sender sender_;
  service::Seats seats_;
  const std::string run_;
  std::atomic<unsigned> gates_{0};
};

Error no_key(const std::string& why) { return {ErrorCode::invalid_request, "the key " + why, "", "--key-file"}; }

}  // namespace

Result<std::unique_ptr<Measurer>> remote(const RemoteOptions& options) {
  const auto base = service::base_of(options.url);
  if (!base) return base.error();
  if (!options.key.empty() && !service::is_key(options.key)) {
    return no_key("is not one line of visible ASCII");
  }
  if (!options.key.empty() && !options.key_in_clear && !service::is_private(*base)) {
    return no_key("would be readable on its way to " + *base + ": use https, or allow it by --key-in-clear");
  }
  std::unique_ptr<Measurer> made = std::make_unique<Remote>(options, *base);
  return made;
}

Result<std::string> service_key(const std::filesystem::path& file) {
  if (file.empty()) {
    const char* variable = std::getenv("MESHGAUGE_KEY");
    return std::string(trimmed(variable ? variable : ""));
  }
  std::ifstream stream(file, std::ios::binary);
  std::string key(kMostKeyBytes + 1, '\0');
  stream.read(key.data(), static_cast<std::streamsize>(key.size()));
  key.resize(static_cast<std::size_t>(stream.gcount()));
  const bool whole = key.size() <= kMostKeyBytes;
  key = std::string(trimmed(key));
  if (whole && service::is_key(key)) return key;
  return no_key("in '" + file.string() + "' cannot be read, or is not one line of visible ASCII");
}

}  // namespace meshgauge::check
