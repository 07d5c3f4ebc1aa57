#include "server/store/errors.h"

#include <cerrno>
#include <system_error>

namespace meshgauge::server::store {

bool means_full(int error_number) { return error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG; }

Error storage_error(int error_number, const std::string& what) {
  const ErrorCode code = means_full(error_number) ? ErrorCode::storage_full : ErrorCode::storage_unavailable;
  return {code, what + ": " + std::system_category().message(error_number), "", ""};
}

}  // namespace meshgauge::server::store
