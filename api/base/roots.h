// Folders below which files may be read for a client that is not trusted to name any file.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/descriptor.h"
#include "api/base/whole_file.h"
#include "engine/result.h"

namespace meshgauge::api {

class Roots {
 public:
  // Resolves symbolic links of the folders' own paths, and opens the folders, here and nowhere else: what is put in
  // their places later is not read. Error: invalid_request when one is no folder. Precondition: there is one at least.
  static Result<Roots> open(const std::vector<std::string>& folders);

  // A file for WholeFile::open_below(): `name` is a relative path of plain components.
  struct Place {
    BaseFolder folder;
    std::string name;

    std::string path() const { return folder.path + "/" + name; }
  };

  // Returns the place of a path that is absolute and below one of the folders, or relative to one of them: of several
  // to the first that has such a file. The file need not exist. Errors: invalid_request for an empty path, '..', a
  // control character, and a path that leads elsewhere.
  Result<Place> find(std::string_view path) const;

  const std::vector<std::string>& folders() const { return folders_; }

 private:
  Roots() = default;

  std::vector<std::string> folders_;  // without symbolic links
  std::vector<std::string> written_;  // the same, absolute, as they were given
  std::vector<std::shared_ptr<const Descriptor>> held_;
};

}  // namespace meshgauge::api
