// Baselines of a git revision: --against.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/compare/mesh_file.h"
#include "check/gate.h"
#include "check/manifest/manifest.h"
#include "check/outcome.h"
#include "check/revision/git.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check {

// A revision of the repository of a folder, and a folder of copies of its files, which is removed with the object. For
// one thread.
class Revision {
 public:
  // `ref`: anything that git takes for a commit. `folder`: a folder of the repository's work tree. Blocks. An Error
  // names --against: an empty `ref` or one that begins with '-', no repository, no such revision, no git. Once
  // `interrupted`, this and take_baselines() end with an Error.
  static Result<Revision> open(const std::string& ref, const std::filesystem::path& folder,
                               const Interrupted& interrupted = never_interrupted);

  const RevisionName& name() const { return name_; }

  // Replaces the baseline of each gate by the file of that path in the revision, named "REF:path" and copied with the
  // files that it needs (Gate::copies); a candidate that is called so gets "./" before its name. The content of a Git
  // LFS pointer comes from the repository's own store. What the revision does not hold is a defect of its gate. Adds a
  // gate "REF:path" with a defect and without a candidate for each file of the revision that matches one of `open` and
  // is the baseline of no gate. An Error: the copies cannot be made, or there are more than kMaxGates. Precondition:
  // called once; the object outlives the measurement.
  Result<Done> take_baselines(std::vector<Gate>& gates, const std::vector<OpenBaselines>& open);

  // Before the process ends without destructors; nothing is read after it.
  void remove_copies();

 private:
  struct Entry {
    std::string mode;
    std::string object;
  };
  // A file of the revision that is needed here.
  struct Copy {
    std::string path;  // in the repository
    std::string object;
    std::filesystem::path place;
    std::string defect;  // empty: none
  };
  struct Folder {
    ~Folder();
    std::filesystem::path path;
  };
  using Needed = std::vector<Copy*>;

  Revision(Git git, RevisionName name) : git_(std::move(git)), name_(std::move(name)) {}

  // Calls `visit` for each file of the revision.
  using Visit = std::function<void(const std::string& path, std::string_view mode, std::string_view object)>;
  Result<Done> list_tree(const Visit& visit) const;
  // Adds what the revision has at these paths, or on the way to them, to tree_, and the files of the same names, upper
  // and lower case aside, to namesakes_.
  Result<Done> read_tree(const std::set<std::string>& paths);
  // The gates of files that match one of `open` and are none of `paths`.
  Result<std::vector<Gate>> without_candidate(const std::vector<OpenBaselines>& open,
                                              const std::set<std::string>& paths) const;
  Result<Done> make_folder();
  // The path in the repository, or what is wrong with it.
  Result<std::string> path_of(const std::filesystem::path& baseline) const;
  Result<std::string> object_of(const std::string& path) const;
  std::string elsewhere(const std::string& path) const;
  void add_copy(const std::string& path);
  void find_object(Copy& copy) const;
  Result<Done> fetch(const Needed& needed);
  // Copies these and adds their number to `read`. `trouble`: why it cannot go on, unless git says it.
  Result<Done> fetch(std::span<Copy* const> needed, std::size_t& read, std::string& trouble);
  Result<Done> fetch_companions();
  // Copies so many bytes of `from`. False: it cannot go on, as `trouble` says unless `from` failed.
  bool take(Copy& copy, std::FILE* from, std::uint64_t bytes, std::string& trouble);
  void resolve_pointer(Copy& copy) const;

  Git git_;
  RevisionName name_;
  std::filesystem::path top_;          // of the work tree
  std::filesystem::path lfs_;          // the store of Git LFS
  std::map<std::string, Entry> tree_;  // by path: those that are needed
  std::map<std::string, std::set<std::string>>
      namesakes_;  // by the name of a file, as spelling_key(): paths of it, two at most
  std::uint64_t copied_bytes_ = 0;
  std::map<std::string, Copy> copies_;
  std::unique_ptr<Folder> folder_;
};

}  // namespace meshgauge::check
