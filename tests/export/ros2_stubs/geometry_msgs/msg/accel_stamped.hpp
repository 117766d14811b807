#include "messages.hpp"
