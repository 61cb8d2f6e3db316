/// This package's messages under names that do not clash with the core's structs.
///
/// roscpp generates messages into namespace predictive_stereo, where the core already has a
/// MovingObject and a RowAlignment. Their message types are renamed here; only this header may
/// include the generated ones.
#pragma once

#include <predictive_stereo/BoundingBox2D.h>
#define MovingObject MovingObjectMsg
#define RowAlignment RowAlignmentMsg
#include <predictive_stereo/MovingObject.h>
#include <predictive_stereo/MovingObjectArray.h>
#include <predictive_stereo/RowAlignment.h>
#undef MovingObject
#undef RowAlignment
