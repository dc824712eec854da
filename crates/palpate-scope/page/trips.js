// Why a lane has no force, as its banner says it.

/**
 * @param {{method: string, trip: string | null, trip_method?: string | null}} lane of the state
 * @param {number} number of the lane, from 1
 * @returns {string | null} null where nothing keeps the force away
 */
export function tripInWords({ method, trip = null, trip_method: culprit = null } = {}, number) {
  if (trip === null) {
    return null;
  }
  if (culprit === null) {
    // The device, the hand or the machine: no method is to blame.
    return `Lane ${number}: no force, because ${trip}.`;
  }
  if (culprit === method) {
    return `${method}: no force, because ${trip}.`;
  }
  return `Lane ${number}: no force, because of ${culprit}, which rendered before: ${trip}. ${method} renders now; Rearm lets the force come back.`;
}
