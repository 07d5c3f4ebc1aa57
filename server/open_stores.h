// All that a process keeps, in the form that the settings ask for.
#pragma once

#include <memory>

#include "engine/result.h"
#include "server/jobs/stores.h"
#include "server/settings.h"
#include "server/store/stores.h"

namespace meshgauge::server {

Result<std::unique_ptr<store::AllStores>> open_stores(const Settings& settings);

// As the handlers are given them. Borrows all.
Stores stores_of(store::AllStores& all, MeshCache& cache, MapCache* maps);

}  // namespace meshgauge::server
