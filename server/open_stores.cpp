#include "server/open_stores.h"

#include "server/store/embedded.h"

namespace meshgauge::server {

Result<std::unique_ptr<store::AllStores>> open_stores(const Settings& settings) {
  if (is_distributed(settings)) {
    return Error{ErrorCode::invalid_request, "this build keeps nothing in a --database", "", ""};
  }
  auto stores = store::EmbeddedStores::open({settings.data_dir});
  if (!stores) return stores.error();
  return std::unique_ptr<store::AllStores>(std::move(*stores));
}

}  // namespace meshgauge::server
