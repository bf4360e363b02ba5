adit_fuzz(track_row CHAIN ROUNDS 10000 DEPENDS adit_pipeline)
