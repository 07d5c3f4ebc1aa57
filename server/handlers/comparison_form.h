// The parts of a comparison as they stream in: a and b exactly once, options at most once, a.files and b.files up to
// kMostBundleFiles times each, within their limits.
#pragma once

#include <memory>
#include <string>

#include "server/handlers/bundle.h"
#include "server/http/multipart.h"
#include "server/http/upload.h"
#include "server/settings.h"

namespace meshgauge::server {

struct Form {
  MeshField a;
  MeshField b;
  std::string options = "{}";  // when the part is not sent
};

class FormReceiver final : public MultipartSink {
 public:
  // Borrows all three.
  FormReceiver(Form& form, const Settings& settings, ByteBudget& budget)
      : form_(form), settings_(settings), budget_(budget) {}

  Refusal begin(const FieldHead& field) override;
  Refusal data(std::string_view piece) override;
  Refusal end() override;

  // After the last part: refuses a form without a or b, and makes of a mesh and its files one upload.
  Refusal complete();

 private:
  Refusal begin_mesh(const FieldHead& field, MeshField& mesh);
  Refusal begin_file(const FieldHead& field, MeshField& mesh);
  Refusal add_option_bytes(std::string_view piece);

  Form& form_;
  const Settings& settings_;
  ByteBudget& budget_;
  std::string current_;        // name of the part that is arriving
  MeshField* mesh_ = nullptr;  // that it belongs to; null for options
  Upload* upload_ = nullptr;   // of it; null for options
  bool options_seen_ = false;
};

}  // namespace meshgauge::server
