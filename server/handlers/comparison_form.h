// Receives the fields of a comparison: a and b once each, options at most once, a.files and b.files up to
// kMostBundleFiles times each.
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
  std::string options = "{}";  // the default if the field is not sent
};

class FormReceiver final : public MultipartSink {
 public:
  // Borrows the form, the settings and the budget of the share.
  FormReceiver(Form& form, const Settings& settings, UploadShare share)
      : form_(form), settings_(settings), share_(std::move(share)) {}

  Refusal begin(const FieldHead& field) override;
  Refusal data(std::string_view piece) override;
  Refusal end() override;

  // Call after the last field: returns a problem if a or b is missing, and combines each mesh with its files.
  Refusal complete();

 private:
  Refusal begin_mesh(const FieldHead& field, MeshField& mesh);
  Refusal begin_file(const FieldHead& field, MeshField& mesh);
  Refusal add_option_bytes(std::string_view piece);

  Form& form_;
  const Settings& settings_;
  const UploadShare share_;
  std::string current_;        // name of the part that is arriving
  MeshField* mesh_ = nullptr;  // that it belongs to; null for options
  Upload* upload_ = nullptr;   // of it; null for options
  bool options_seen_ = false;
};

}  // namespace meshgauge::server
