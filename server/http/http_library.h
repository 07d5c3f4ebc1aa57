// The only way to include cpp-httplib: its <resolv.h> defines a macro _res that Eigen's headers trip over.
#pragma once

#include <Eigen/Core>

#include <httplib.h>
