// Rights of the files and folders that the service makes in its data folder: their owner's alone, or also those of the
// folder's group where the folder says so. A container's volume does: the next process may run as another user, of the
// same group.
#pragma once

#include <string>

#include "api/descriptor.h"
#include "engine/result.h"

namespace meshgauge::server::store {

// Makes a folder with mode 0700; within a shared folder 0770, and shared as well. false: it existed. Not durable before
// sync_folder() of its parent. A folder is shared if its group may do all that its owner may, and either it is of group
// 0, which all processes of a container have, and others may not write; or new files get its group (setgid), and others
// have no rights at all.
Result<bool> make_folder(const std::string& path);

// As open() with O_CLOEXEC. A file that it makes has mode 0600; within a shared folder 0660, whatever the umask is.
// Where it may make a file in a shared folder, it follows no link at `path`: ELOOP.
Descriptor open_file(const std::string& path, int flags);

// As storage_error() for what cannot be done with `path`. If permission was denied, it also says which user the process
// runs as, which user and mode the path (or the first folder above that can be seen) has, and what to do.
Error access_error(int error_number, const std::string& what, const std::string& path);

}  // namespace meshgauge::server::store
