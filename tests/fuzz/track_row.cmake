adit_fuzz(track_row ROUNDS 10000 DEPENDS adit_pipeline)
