// Receives the fields of a comparison: a and b once each, options at most once, a.files and b.files up to
// kMostBundleFiles times each. From the first field of another name on it discards what comes, up to 16 MiB, so that
// its problem names all the fields.
#pragma once

#include <string>
#include <vector>

#include "server/http/bundle.h"
#include "server/http/multipart.h"
#include "server/http/upload.h"
#include "server/settings/settings.h"

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
  api::Problem unknown() const;
  api::Problem missing(const std::string& part) const;
  std::string fields_sent() const;

  Form& form_;
  const Settings& settings_;
  const UploadShare share_;
  std::string current_;        // name of the part that is arriving
  MeshField* mesh_ = nullptr;  // that it belongs to; null for options
  Upload* upload_ = nullptr;   // of it; null for options
  bool options_seen_ = false;
  std::string unknown_;             // name of the first unknown part; "": there is none
  std::uint64_t discarded_ = 0;     // bytes since that part
  std::vector<std::string> names_;  // of the first parts, for messages
  std::size_t count_ = 0;           // of all parts
};

}  // namespace meshgauge::server
