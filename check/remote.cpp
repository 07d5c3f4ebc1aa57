#include "check/remote.h"

#include <cstdlib>
#include <span>
#include <utility>

#include "api/digest.h"
#include "api/refused.h"
#include "api/text_file.h"
#include "check/remote/address.h"
#include "check/remote/comparison.h"
#include "check/remote/pair.h"
#include "check/remote/together.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

constexpr std::size_t kMostKeyBytes = 4096;

class Remote final : public Measurer {
 public:
  Remote(const RemoteOptions& options, const std::string& base) : shared_(options, base, api::random_id()) {}

  Result<Measured> measure(const Gate& gate, Control& control) override {
    service::Pair pair(shared_.sender, gate, control);
    auto document = service::Comparison(shared_.client, shared_.limit, pair, shared_.next_key(), control).measure();
    return service::measured_of(shared_, pair, std::move(document));
  }

  unsigned at_once() const override { return shared_.limit.most(); }
  std::size_t together() const override { return shared_.most_of_batch; }
  void measure_together(std::span<const Task> tasks) override { service::Together(shared_, tasks).measure(); }

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
