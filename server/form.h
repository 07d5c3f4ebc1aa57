// The parts of a comparison as they stream in: a and b exactly once, options at most once, within their limits.
#pragma once

#include <memory>
#include <string>

#include "server/multipart.h"
#include "server/settings.h"
#include "server/upload.h"

namespace meshgauge::server {

struct MeshPart {
  PartHead head;
  std::unique_ptr<Upload> upload;
};

struct Form {
  MeshPart a;
  MeshPart b;
  std::string options = "{}";  // when the part is not sent
};

class FormReceiver final : public MultipartSink {
 public:
  // Borrows all three.
  FormReceiver(Form& form, const Settings& settings, ByteBudget& budget)
      : form_(form), settings_(settings), budget_(budget) {}

  Refusal begin(const PartHead& part) override;
  Refusal data(std::string_view piece) override;
  Refusal end() override;

  Refusal check_complete() const;

 private:
  Refusal add_option_bytes(std::string_view piece);

  Form& form_;
  const Settings& settings_;
  ByteBudget& budget_;
  std::string current_;       // name of the part that is arriving
  Upload* upload_ = nullptr;  // of it; null for options
  bool options_seen_ = false;
};

}  // namespace meshgauge::server
